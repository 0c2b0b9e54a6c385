# SPDX-License-Identifier: GPL-3.0-or-later
"""Seconds in which dolfinx assembles the Jacobian of the semi-discrete flow equations on a mesh, one core.

usage: dolfinx_jacobian.py POINTS CELLS [REPETITIONS]: files of float64 {n, 3} and int32 {m, 4}

The weak form of fluid_solver/instant.hpp: Galerkin, SUPG, PSPG and LSIC, with viscosity and stabilisation
parameters held, constant in an element; four unknowns a node, blocked; a quadrature that is exact for it. Prints the
least of some assemblies into a matrix that is there already. Exit status 3: dolfinx is not installed.
"""
import sys
import time

try:
    import dolfinx
    import dolfinx.fem.petsc
    import numpy as np
    import ufl
    from mpi4py import MPI
except ImportError as missing:
    print(f"not installed: {missing}", file=sys.stderr)
    sys.exit(3)


def tetrahedra(points_file: str, cells_file: str) -> dolfinx.mesh.Mesh:
    points = np.fromfile(points_file).reshape(-1, 3)
    cells = np.fromfile(cells_file, dtype=np.int32).reshape(-1, 4)
    shape = ufl.Mesh(ufl.VectorElement("Lagrange", ufl.tetrahedron, 1))
    return dolfinx.mesh.create_mesh(MPI.COMM_SELF, cells.astype(np.int64), points, shape)


def jacobian(mesh: dolfinx.mesh.Mesh) -> dolfinx.fem.FormMetaClass:
    nodal = dolfinx.fem.FunctionSpace(mesh, ufl.VectorElement("Lagrange", mesh.ufl_cell(), 1, dim=4))
    constant = dolfinx.fem.FunctionSpace(mesh, ("DG", 0))
    w, test = dolfinx.fem.Function(nodal), ufl.TestFunction(nodal)
    nu, tau, tau_lsic = (dolfinx.fem.Function(constant) for _ in range(3))
    nu.x.array[:], tau.x.array[:], tau_lsic.x.array[:] = 1.5e-4, 1.6e-3, 5.0
    w.x.array[2::4] = 22 + np.sin(0.01 * np.arange(len(w.x.array[2::4])))
    u, p = ufl.as_vector([w[0], w[1], w[2]]), w[3]
    v, q = ufl.as_vector([test[0], test[1], test[2]]), test[3]
    rate = dolfinx.fem.Constant(mesh, 1 / 0.0032)
    inertia = rate * u + ufl.dot(ufl.grad(u), u)
    residual = inertia + ufl.grad(p)
    form = (ufl.inner(inertia, v) - p * ufl.div(v) + 2 * nu * ufl.inner(ufl.sym(ufl.grad(u)), ufl.grad(v))
            + tau_lsic * ufl.div(u) * ufl.div(v) + q * ufl.div(u)
            + tau * ufl.inner(ufl.dot(ufl.grad(v), u) + ufl.grad(q), residual))
    form *= ufl.dx(metadata={"quadrature_degree": 2})
    options = {"cffi_extra_compile_args": ["-O3", "-march=native", "-fno-math-errno"]}
    return dolfinx.fem.form(ufl.derivative(form, w), jit_params=options)


def main() -> None:
    form = jacobian(tetrahedra(sys.argv[1], sys.argv[2]))
    matrix = dolfinx.fem.petsc.create_matrix(form)
    least = float("inf")
    for _ in range(int(sys.argv[3]) if len(sys.argv) > 3 else 3):
        matrix.zeroEntries()
        start = time.process_time()
        dolfinx.fem.petsc.assemble_matrix(matrix, form)
        matrix.assemble()
        least = min(least, time.process_time() - start)
    print(least)


if __name__ == "__main__":
    main()
