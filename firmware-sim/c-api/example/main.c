/* The ballrace device from C: runs a model over samples and prints the line of JSON that `ballrace-firmware-sim` prints,
   with its CRC-32 over every intermediate number. Model and samples are linked in (embedded.S). */
#include <string.h>

#include "ballrace.h"
#include "platform.h"

/* Of embedded.S. */
extern const uint8_t model[], model_end[], samples[], samples_end[];

/* Memory of the device: enough for 2048 floats of scratch. A program whose model is known takes the number that
   `ballrace export --format c` writes, BALLRACE_MODEL_SCRATCH_LEN. */
static uint64_t memory[BALLRACE_MEMORY_SIZE(2048) / sizeof(uint64_t)];

/* CRC-32 (IEEE 802.3) of 32-bit words, little-endian. */
static uint32_t crc = UINT32_MAX;

static void fold_word(uint32_t word)
{
    crc ^= word;
    for (int bit = 0; bit < 32; bit++)
        crc = crc & 1 ? crc >> 1 ^ UINT32_C(0xedb88320) : crc >> 1;
}

static void fold_float(float value)
{
    uint32_t word;
    memcpy(&word, &value, sizeof word);
    /* The sign of the NaN of infinity - infinity depends on the processor. */
    fold_word(value != value ? UINT32_C(0x7fc00000) : word);
}

static void fold_floats(const float *values, size_t count)
{
    for (size_t i = 0; i < count; i++)
        fold_float(values[i]);
}

static void fold_block(const ballrace_block *block)
{
    fold_word(block->ended);
    if (!block->ended)
        return;
    fold_word(block->block);
    fold_float(block->level);
    fold_float(block->deviation);
    fold_float(block->ewma);
    fold_word(block->beyond);
    fold_word((uint32_t)block->status);
    fold_word((uint32_t)block->was);
}

static void fold_result(const ballrace_result *result)
{
    const ballrace_step *step = &result->step;
    fold_word((uint32_t)result->quality);
    fold_word(result->evaluated);
    if (result->evaluated) {
        fold_floats(step->states, step->state_count);
        fold_floats(step->latent, step->latent_count);
        fold_floats(step->latent_rate, step->latent_count);
        fold_floats(step->predicted, step->state_count);
        fold_floats(step->measured, step->state_count);
        fold_floats(step->expected, step->state_count);
        for (size_t i = 0; step->comparable && i < step->state_count; i++)
            fold_float(step->measured[i] - step->expected[i]);
        fold_word(step->has_next_sample);
        fold_float(step->next_sample);
    }
    fold_block(&result->block);
}

/* Line of text: printf would bring a heap. */
static char line[512];
static size_t length;

static void text(const char *more)
{
    while (*more != 0 && length + 1 < sizeof line)
        line[length++] = *more++;
}

static void number(const char *key, uint32_t value)
{
    char digits[11] = "";
    size_t at = sizeof digits - 1;
    do {
        digits[--at] = (char)('0' + value % 10);
        value /= 10;
    } while (value != 0);
    text(key);
    text(digits + at);
}

static void hexadecimal(uint32_t value)
{
    for (int shift = 28; shift >= 0; shift -= 4) {
        const char digit[2] = {"0123456789abcdef"[value >> shift & 15], 0};
        text(digit);
    }
}

static void check(ballrace_error error)
{
    if (error == BALLRACE_ERROR_NONE)
        return;
    say(ballrace_error_text(error));
    leave(1);
}

int main(void)
{
    static const char *const status[] = {"starting", "healthy", "anomalous", "blind"};
    const size_t model_len = (size_t)(model_end - model), count = (size_t)(samples_end - samples) / sizeof(float);
    ballrace_device *device;
    size_t needed;
    check(ballrace_memory_size(model, model_len, &needed));
    check(ballrace_init(memory, sizeof memory, model, model_len, &device));

    uint32_t evaluated = 0, blocks = 0, anomalous_blocks = 0;
    ballrace_block last;
    for (size_t i = 0; i < count; i++) {
        float sample;
        ballrace_result result;
        memcpy(&sample, samples + i * sizeof sample, sizeof sample);
        check(ballrace_push(device, sample, &result));
        fold_result(&result);
        evaluated += result.evaluated;
        if (result.block.ended) {
            blocks = result.block.block;
            anomalous_blocks += result.block.status == BALLRACE_STATUS_ANOMALOUS;
        }
    }
    check(ballrace_end_of_recording(device, &last));
    fold_block(&last);
    if (last.ended) {
        blocks = last.block;
        anomalous_blocks += last.status == BALLRACE_STATUS_ANOMALOUS;
    }

    ballrace_summary summary;
    check(ballrace_get_summary(device, &summary));
    text("{\"crc\":\"");
    hexadecimal(~crc);
    number("\",\"samples\":", (uint32_t)count);
    number(",\"evaluated\":", evaluated);
    number(",\"blocks\":", blocks);
    number(",\"anomalous_blocks\":", anomalous_blocks);
    text(",\"status\":\"");
    text(status[summary.status]);
    number("\",\"faults\":{\"non_finite\":", summary.non_finite);
    number(",\"saturated\":", summary.saturated);
    number(",\"stuck\":", summary.stuck);
    number(",\"missing\":", summary.missing);
    text("}}");
    say(line);
    leave(0);
}
