/* Model and samples in read-only memory: assembled with -DMODEL="\"model.bin\"" -DSAMPLES="\"samples.f32\"". */
    .section .rodata
    .balign 4
    .global model, model_end, samples, samples_end
model:
    .incbin MODEL
model_end:
    .balign 4
samples:
    .incbin SAMPLES
samples_end:
#if defined(__linux__)
    .section .note.GNU-stack, "", %progbits
#endif
