# SPDX-License-Identifier: Apache-2.0
"""Deforms a model by a lattice: deform.py MODEL REST POSE OUT"""

import sys

import espalier

model = espalier.read_model(sys.argv[1])
rest, pose = espalier.read(sys.argv[2]), espalier.read(sys.argv[3])

# Once: find each point of the model in level 3 of the lattice, and compose the matrix.
binding = espalier.bind(rest, model, level=3)
D = binding.matrix  # scipy.sparse.csr_matrix: points × lattice vertices

# For every pose: one sparse product.
model.write(sys.argv[4], binding.deform(pose))
