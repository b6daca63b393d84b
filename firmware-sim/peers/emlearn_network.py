"""Network of weights.txt as C, by emlearn's own generator: emlearn_network.py WEIGHTS.txt OUT.h"""
import sys

import numpy
from emlearn.net import c_generate_net_loadable

# A paragraph a layer: a line of weights for each output, then the biases.
layers = [[line.split() for line in text.splitlines()] for text in open(sys.argv[1]).read().strip().split("\n\n")]
weights = [numpy.array(rows[:-1], dtype=numpy.float32).T for rows in layers]
biases = [numpy.array(rows[-1], dtype=numpy.float32) for rows in layers]
open(sys.argv[2], "w").write(c_generate_net_loadable(["logistic", "identity"], weights, biases, prefix="network"))
