/* CMSIS-NN, 16-bit activations with 8-bit weights: two fully connected layers, and its interpolated table of the sigmoid. */
#include <arm_nnfunctions.h>

#include "network.h"
#include "peer.h"

static int16_t input[INPUTS], hidden[HIDDEN], output[OUTPUTS];

void prepare(void)
{
}

static int16_t quantised(float x)
{
    const float scaled = x * S16_INPUT_PER_UNIT;
    const int32_t whole = (int32_t)(scaled + (scaled < 0 ? -0.5f : 0.5f));
    return (int16_t)(whole < -32768 ? -32768 : whole > 32767 ? 32767 : whole);
}

static void layer(const int16_t *x, const int8_t *weights, const int64_t *biases, int16_t *y, int from, int to,
                  int32_t multiplier, int32_t shift)
{
    const cmsis_nn_context context = {0};
    const cmsis_nn_fc_params parameters = {.activation = {-32768, 32767}};
    const cmsis_nn_per_tensor_quant_params scale = {multiplier, shift};
    const cmsis_nn_dims x_dims = {1, 1, 1, from}, w_dims = {from, 1, 1, to}, b_dims = {1, 1, 1, to}, y_dims = {1, 1, 1, to};
    arm_fully_connected_s16(&context, &parameters, &scale, &x_dims, x, &w_dims, weights, &b_dims, biases, &y_dims, y);
}

__attribute__((noinline)) void kernel(const float *x, float *y)
{
    for (int i = 0; i < INPUTS; i++)
        input[i] = quantised(x[i]);
    layer(input, s8_weights1, s16_biases1, hidden, INPUTS, HIDDEN, S16_MULTIPLIER1, S16_SHIFT1);
    arm_nn_activation_s16(hidden, hidden, HIDDEN, 0, ARM_SIGMOID);
    layer(hidden, s8_weights2, s16_biases2, output, HIDDEN, OUTPUTS, S16_MULTIPLIER2, S16_SHIFT2);
    for (int o = 0; o < OUTPUTS; o++)
        y[o] = (float)output[o] * S16_UNIT_PER_OUTPUT;
}
