/* emlearn's network in single precision, as its generator writes it. */
#include "emlearn_network.h"
#include "network.h"
#include "peer.h"

void prepare(void)
{
}

__attribute__((noinline)) void kernel(const float *x, float *y)
{
    network_regress(x, INPUTS, y, OUTPUTS);
}
