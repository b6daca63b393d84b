/* What a peer gives the harness. */
#ifndef PEER_H
#define PEER_H

/* Once, before the first pass. */
void prepare(void);

/* One pass: INPUTS numbers to OUTPUTS numbers. */
void kernel(const float *x, float *y);

#endif
