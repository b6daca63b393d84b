/* The ballrace device in C: screen, evaluator and monitor of one channel, in fixed memory of the caller's.

   Every function returns an error and changes nothing when it fails; none allocates, unwinds or keeps global state. A
   device may be used from one context at a time; different devices are independent. */

#ifndef BALLRACE_H
#define BALLRACE_H

/* Made by cbindgen from firmware-sim/c-api/src/: BALLRACE_BLESS=1 cargo test writes it anew. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
/* Bytes of memory that a model of `scratch_len` floats of scratch needs at most, for a static array; `ballrace export
   --format c` writes the number as BALLRACE_MODEL_SCRATCH_LEN. */
#define BALLRACE_MEMORY_SIZE(scratch_len) (BALLRACE_STATE_SIZE + 4 * (scratch_len))

/*
 Bytes that a device needs at most beside the model's scratch, on 32-bit and 64-bit machines.
 */
#define BALLRACE_STATE_SIZE 1536

/*
 Alignment that the memory of a device needs, bytes.
 */
#define BALLRACE_MEMORY_ALIGNMENT 8

/*
 Error of a call. 0 is success.
 */
enum ballrace_error
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /*
     Success.
     */
    BALLRACE_ERROR_NONE = 0,
    /*
     A pointer is null.
     */
    BALLRACE_ERROR_NULL_POINTER = 1,
    /*
     The memory is too short: `ballrace_memory_size` says what the model needs.
     */
    BALLRACE_ERROR_MEMORY_TOO_SMALL = 2,
    /*
     The memory is not aligned to `BALLRACE_MEMORY_ALIGNMENT` bytes.
     */
    BALLRACE_ERROR_MEMORY_MISALIGNED = 3,
    /*
     The handle is not one that `ballrace_init` gave, or its memory was overwritten.
     */
    BALLRACE_ERROR_NOT_A_DEVICE = 4,
    /*
     The model has fewer bytes than it says.
     */
    BALLRACE_ERROR_MODEL_TRUNCATED = 5,
    /*
     The bytes are not a model.
     */
    BALLRACE_ERROR_MODEL_MAGIC = 6,
    /*
     The model is of a version of the format that this library does not read.
     */
    BALLRACE_ERROR_MODEL_VERSION = 7,
    /*
     The model's checksum differs: its bytes were changed after they were written.
     */
    BALLRACE_ERROR_MODEL_CHECKSUM = 8,
    /*
     The model's header or sizes are out of range.
     */
    BALLRACE_ERROR_MODEL_HEADER = 9,
    /*
     A number of the model is not finite, not positive, or out of range.
     */
    BALLRACE_ERROR_MODEL_CONTENT = 10,
    /*
     The model takes states, not samples.
     */
    BALLRACE_ERROR_MODEL_TAKES_STATES = 11,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ballrace_error ballrace_error;
#else
typedef int32_t ballrace_error;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Quality of a sample.
 */
enum ballrace_quality
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /*
     Good: is evaluated.
     */
    BALLRACE_QUALITY_GOOD = 0,
    /*
     NaN or infinite.
     */
    BALLRACE_QUALITY_NON_FINITE = 1,
    /*
     At or beyond the sensor's full scale.
     */
    BALLRACE_QUALITY_SATURATED = 2,
    /*
     Equal to too many samples before it.
     */
    BALLRACE_QUALITY_STUCK = 3,
    /*
     Not received.
     */
    BALLRACE_QUALITY_MISSING = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ballrace_quality ballrace_quality;
#else
typedef int32_t ballrace_quality;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Status of the machine.
 */
enum ballrace_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /*
     Too few blocks so far.
     */
    BALLRACE_STATUS_STARTING = 0,
    /*
     Residual of the healthy machine.
     */
    BALLRACE_STATUS_HEALTHY = 1,
    /*
     Residual that differs from the healthy machine's.
     */
    BALLRACE_STATUS_ANOMALOUS = 2,
    /*
     Too many broken samples.
     */
    BALLRACE_STATUS_BLIND = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ballrace_status ballrace_status;
#else
typedef int32_t ballrace_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 A device in the caller's memory.
 */
typedef struct ballrace_device ballrace_device;

/*
 Step of the model, in its scaled units unless stated otherwise. The arrays are the device's, valid until the next call
 with it.
 */
typedef struct {
    /*
     Length of `states`, `predicted`, `measured` and `expected`.
     */
    size_t state_count;
    /*
     Length of `latent` and `latent_rate`.
     */
    size_t latent_count;
    /*
     Virtual states, in physical units.
     */
    const float *states;
    /*
     Latent variables.
     */
    const float *latent;
    /*
     Rates of the latent variables.
     */
    const float *latent_rate;
    /*
     Predicted derivatives. A causal model's belong to the next sample.
     */
    const float *predicted;
    /*
     Measured derivatives of this step's target instant.
     */
    const float *measured;
    /*
     Prediction of `measured`: for a causal model that of the step before.
     */
    const float *expected;
    /*
     Whether `measured` and `expected` belong together; their difference is the residual.
     */
    bool comparable;
    /*
     Whether the model predicts the next sample.
     */
    bool has_next_sample;
    /*
     Predicted next sample, m/s^2; else 0.
     */
    float next_sample;
} ballrace_step;

/*
 Monitor's statistics after a block.
 */
typedef struct {
    /*
     Whether the call ended a block; if not, the rest is zero.
     */
    bool ended;
    /*
     Whether the EWMA is beyond its limit.
     */
    bool beyond;
    /*
     Blocks so far, this one included; saturating.
     */
    uint32_t block;
    /*
     Mean squared normalised residual; NaN for a blind block.
     */
    float level;
    /*
     Distance of the level's logarithm from its healthy centre in healthy spreads; NaN for a blind block.
     */
    float deviation;
    /*
     EWMA of the running median of the deviation, which the limit judges.
     */
    float ewma;
    /*
     Status after this block.
     */
    ballrace_status status;
    /*
     Status before this block; a change is an event.
     */
    ballrace_status was;
} ballrace_block;

/*
 Result of one sample.
 */
typedef struct {
    /*
     Quality of the sample; only good ones are evaluated.
     */
    ballrace_quality quality;
    /*
     Whether the model was evaluated; not for a broken sample, and not while the differences fill.
     */
    bool evaluated;
    /*
     Step of the model, if it was evaluated.
     */
    ballrace_step step;
    /*
     Statistics of the block that the sample ended, if it ended one.
     */
    ballrace_block block;
} ballrace_result;

/*
 Totals since the start; the counts saturate.
 */
typedef struct {
    /*
     Current status.
     */
    ballrace_status status;
    /*
     NaN or infinite samples.
     */
    uint32_t non_finite;
    /*
     Samples at or beyond full scale.
     */
    uint32_t saturated;
    /*
     Samples in stuck runs, counted from the one that made the run too long.
     */
    uint32_t stuck;
    /*
     Samples not received.
     */
    uint32_t missing;
} ballrace_summary;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 Says how many bytes of memory a device with a model needs. The model is the binary form, `ballrace export --format bin`
 or `c`; it is checked.

 # Safety
 `model` is null or `model_len` readable bytes, `size` null or writable.
 */
ballrace_error ballrace_memory_size(const uint8_t *model, size_t model_len, size_t *size);

/*
 Makes a device in `memory`, which is `BALLRACE_MEMORY_ALIGNMENT`-aligned, and gives its handle. The model is checked and
 used where it lies: model and memory must stay, the model unchanged, as long as the device is used. There is nothing to
 free; a new device may be made in the same memory.

 # Safety
 `memory` is null or `memory_len` bytes that nothing else uses, `model` null or `model_len` readable bytes, both as long
 as the device is used; `device` is null or writable.
 */
ballrace_error ballrace_init(void *memory,
                             size_t memory_len,
                             const uint8_t *model,
                             size_t model_len,
                             ballrace_device **device);

/*
 Takes a sample, m/s^2.

 # Safety
 `device` is null or a handle of `ballrace_init` that nothing else uses, `result` null or writable.
 */
ballrace_error ballrace_push(ballrace_device *device, float sample, ballrace_result *result);

/*
 Takes the number of samples not received.

 # Safety
 `device` is null or a handle of `ballrace_init` that nothing else uses, `block` null or writable.
 */
ballrace_error ballrace_missing(ballrace_device *device, uint32_t count, ballrace_block *block);

/*
 Ends a recording: the next sample does not continue it, which is no fault.

 # Safety
 `device` is null or a handle of `ballrace_init` that nothing else uses, `block` null or writable.
 */
ballrace_error ballrace_end_of_recording(ballrace_device *device, ballrace_block *block);

/*
 Gives the current status and the counts of broken samples.

 # Safety
 `device` is null or a handle of `ballrace_init` that nothing else uses, `summary` null or writable.
 */
ballrace_error ballrace_get_summary(ballrace_device *device, ballrace_summary *summary);

/*
 Says what an error means, in one sentence; never null.
 */
const char *ballrace_error_text(int32_t error);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* BALLRACE_H */
