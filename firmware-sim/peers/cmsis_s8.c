/* CMSIS-NN, 8-bit: two fully connected layers, and between them the sigmoid as a table of all 256 values, as TensorFlow Lite
 * for microcontrollers does it. */
#include <arm_nnfunctions.h>

#include "network.h"
#include "peer.h"

static int8_t input[INPUTS], hidden[HIDDEN], output[OUTPUTS];

void prepare(void)
{
}

static int8_t quantised(float x)
{
    const float scaled = x * S8_INPUT_PER_UNIT;
    const int32_t whole = (int32_t)(scaled + (scaled < 0 ? -0.5f : 0.5f));
    return (int8_t)(whole < -128 ? -128 : whole > 127 ? 127 : whole);
}

static void layer(const int8_t *x, const int8_t *weights, const int32_t *biases, int8_t *y, int from, int to,
                  int32_t input_offset, int32_t multiplier, int32_t shift)
{
    const cmsis_nn_context context = {0};
    const cmsis_nn_fc_params parameters = {.input_offset = input_offset, .activation = {-128, 127}};
    const cmsis_nn_per_tensor_quant_params scale = {multiplier, shift};
    const cmsis_nn_dims x_dims = {1, 1, 1, from}, w_dims = {from, 1, 1, to}, b_dims = {1, 1, 1, to}, y_dims = {1, 1, 1, to};
    arm_fully_connected_s8(&context, &parameters, &scale, &x_dims, x, &w_dims, weights, &b_dims, biases, &y_dims, y);
}

__attribute__((noinline)) void kernel(const float *x, float *y)
{
    for (int i = 0; i < INPUTS; i++)
        input[i] = quantised(x[i]);
    layer(input, s8_weights1, s8_biases1, hidden, INPUTS, HIDDEN, 0, S8_MULTIPLIER1, S8_SHIFT1);
    for (int i = 0; i < HIDDEN; i++)
        hidden[i] = s8_sigmoid[(uint8_t)hidden[i]];
    layer(hidden, s8_weights2, s8_biases2, output, HIDDEN, OUTPUTS, 128, S8_MULTIPLIER2, S8_SHIFT2);
    for (int o = 0; o < OUTPUTS; o++)
        y[o] = (float)output[o] * S8_UNIT_PER_OUTPUT;
}
