# SPDX-License-Identifier: Apache-2.0
"""A box as finite elements of scikit-fem, with the energy of a neo-Hookean solid.

    E(u) = sum_e sum_q w_q psi(F_q),      F_q = I + sum_a u_a (x) dN_a/dX(X_q)
    psi  = mu/2 (|F|^2 - 3) - mu ln J + lambda/2 (ln J)^2
    P    = mu F + (lambda ln J - mu) F^-T
    dP   = mu dF + lambda tr(F^-1 dF) F^-T + (mu - lambda ln J) F^-T dF^T F^-T

Meshes, shape functions, quadrature, numbering, masses, loads and face integrals are those of
scikit-fem. The sums over quadrature points of E and its derivatives are products of arrays here,
because its loop over all pairs of shape functions takes 23 s for one matrix of 20,000 unknowns of
hex27 in place of 0.17 s; skfem_check.py compares the two.

Displacements u are (nodes, 3) [m]; degree of freedom 3 node + component.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
import skfem
from numpy.typing import NDArray

from scene_file import FACES, Material

Floats = NDArray[np.float64]

# element -> shape functions, degree that the quadrature of E integrates exactly (2 x 2 x 2,
# 3 x 3 x 3 and 4 points), the same for masses (N_a N_b without error)
TABLE = {"hex": (skfem.ElementHex1, 3, 3),
         "hex27": (skfem.ElementHex2, 5, 5),
         "tet10": (skfem.ElementTetP2, 2, 4)}


def box_mesh(box: tuple[float, float, float], cells: tuple[int, int, int],
             element: str) -> skfem.Mesh:
    """Equal cells; each of six tetrahedra about its diagonal (1, 1, 1) for tet10."""
    kind = skfem.MeshTet if element == "tet10" else skfem.MeshHex
    return kind.init_tensor(*(np.linspace(0, box[d], cells[d] + 1) for d in range(3)))


class Body:
    """One material on one mesh."""

    def __init__(self, mesh: skfem.Mesh, element: str, material: Material) -> None:
        shape, degree, self._mass_degree = TABLE[element]
        self.material = material
        self.mesh = mesh
        self._shape = shape()
        basis = skfem.Basis(mesh, self._shape, intorder=degree)
        self.rest: Floats = basis.doflocs.T.copy()  # (nodes, 3) [m]
        self.elements = basis.element_dofs.T.astype(np.int64)  # (elements, n)
        self.weight: Floats = basis.dx  # (elements, points) [m^3]
        gradients = [basis.basis[a][0].grad for a in range(basis.Nbfun)]
        # dN_a/dX [1/m], (elements, points, n, 3)
        self.shape_gradient: Floats = np.stack(gradients).transpose(2, 3, 0, 1).copy()
        self._make_pattern()

    @property
    def nodes(self) -> int:
        return len(self.rest)

    def _make_pattern(self) -> None:
        """Where the entries of the element matrices go in the sparse matrix."""
        size = 3 * self.nodes
        dofs = (3 * self.elements[:, :, None] + np.arange(3)).reshape(len(self.elements), -1)
        keys = (dofs[:, :, None] * size + dofs[:, None, :]).ravel()
        self._order = np.argsort(keys, kind="stable")
        keys = keys[self._order]
        self._starts = np.flatnonzero(np.diff(keys, prepend=-1))
        rows, self._columns = np.divmod(keys[self._starts], size)
        self._row_starts = np.searchsorted(rows, np.arange(size + 1))

    @property
    def nonzeros(self) -> int:
        """Entries of the sparse matrix of all degrees of freedom."""
        return len(self._starts)

    # --- energy and derivatives

    def deformation_gradient(self, u: Floats) -> Floats:
        """F, (elements, points, 3, 3)."""
        corners = u[self.elements].transpose(0, 2, 1)[:, None]
        F: Floats = corners @ self.shape_gradient + np.eye(3)
        return F

    def min_j(self, u: Floats) -> float:
        """Smallest det F of a quadrature point."""
        return float(np.linalg.det(self.deformation_gradient(u)).min())

    def energy(self, u: Floats) -> float:
        """E(u) [J]; infinite where J <= 0 in a quadrature point."""
        F = self.deformation_gradient(u)
        J = np.linalg.det(F)
        if not J.min() > 0:
            return float("inf")
        m, log_j = self.material, np.log(J)
        psi = m.mu / 2 * ((F * F).sum((2, 3)) - 3) - m.mu * log_j + m.lam / 2 * log_j**2
        return float((self.weight * psi).sum())

    def first_piola(self, F: Floats) -> Floats:
        """P [Pa], shaped as F."""
        m = self.material
        pressure = m.lam * np.log(np.linalg.det(F)) - m.mu
        P: Floats = m.mu * F + pressure[..., None, None] * np.linalg.inv(F).swapaxes(-1, -2)
        return P

    def gradient(self, u: Floats) -> Floats:
        """dE/du [N], (nodes, 3)."""
        P = self.weight[:, :, None, None] * self.first_piola(self.deformation_gradient(u))
        f = (self.shape_gradient @ P.swapaxes(2, 3)).sum(1)
        place = self.elements.ravel()
        return np.stack([np.bincount(place, f[:, :, i].ravel(), self.nodes) for i in range(3)], 1)

    def element_hessians(self, u: Floats) -> Floats:
        """d2E/du2 of each element [N/m], (elements, 3 n, 3 n).

        With b_a = F^-T dN_a/dX the block of nodes a, b is the sum over points of
        w (mu dN_a.dN_b I + lambda b_a (x) b_b + (mu - lambda ln J) b_b (x) b_a).
        """
        m, w = self.material, self.weight
        F = self.deformation_gradient(u)
        elements, points, n, _ = self.shape_gradient.shape
        twist = m.mu - m.lam * np.log(np.linalg.det(F))
        b = (self.shape_gradient @ np.linalg.inv(F)).reshape(elements, points, 3 * n)
        across = b.swapaxes(1, 2)
        K = (across * (m.lam * w)[:, None, :]) @ b
        crossed = ((across * (twist * w)[:, None, :]) @ b).reshape(elements, n, 3, n, 3)
        K = K.reshape(crossed.shape) + crossed.swapaxes(2, 4)
        G = self.shape_gradient.transpose(0, 2, 1, 3).reshape(elements, n, 3 * points)
        constant = (G * np.repeat(m.mu * w, 3, axis=1)[:, None, :]) @ G.swapaxes(1, 2)
        for i in range(3):
            K[:, :, i, :, i] += constant
        return K.reshape(elements, 3 * n, 3 * n)

    def hessian(self, u: Floats) -> sparse.csr_matrix:
        """d2E/du2 [N/m] of all degrees of freedom."""
        values = np.add.reduceat(self.element_hessians(u).ravel()[self._order], self._starts)
        return sparse.csr_matrix((values, self._columns, self._row_starts),
                                 (3 * self.nodes, 3 * self.nodes))

    # --- mass, loads, faces

    def mass(self, kind: str) -> sparse.csr_matrix:
        """rho N_a N_b integrated [kg], of all degrees of freedom; lumped: its row sums."""
        basis = skfem.Basis(self.mesh, self._shape, intorder=self._mass_degree)
        M = self.material.density * skfem.BilinearForm(lambda u, v, _: u * v).assemble(basis)
        if kind == "lumped":
            M = sparse.diags_array(np.asarray(M.sum(1)).ravel())
        return sparse.csr_matrix(sparse.kron(M, sparse.eye_array(3)))

    def weight_force(self, gravity: tuple[float, float, float]) -> Floats:
        """integral rho N_a g dV [N], (nodes, 3)."""
        basis = skfem.Basis(self.mesh, self._shape, intorder=self._mass_degree)
        volume = skfem.LinearForm(lambda v, _: v).assemble(basis)
        force: Floats = self.material.density * volume[:, None] * np.array(gravity)
        return force

    def face_nodes(self, face: str) -> NDArray[np.int64]:
        """Nodes on a face of the box."""
        axis, end = divmod(FACES.index(face), 2)
        place = self.rest[:, axis]
        limit = place.max() if end else place.min()
        return np.flatnonzero(np.abs(place - limit) < 1e-9 * np.ptp(place))

    def face_mean(self, face: str) -> Floats:
        """Weights of the nodes whose sum with u is the mean over a face of the box, (nodes,)."""
        axis, end = divmod(FACES.index(face), 2)
        place = self.rest[:, axis]
        limit = place.max() if end else place.min()
        facets = self.mesh.facets_satisfying(lambda x: np.isclose(x[axis], limit), True)
        basis = skfem.FacetBasis(self.mesh, self._shape, facets=facets, intorder=4)
        area: Floats = skfem.LinearForm(lambda v, _: v).assemble(basis)
        return area / area.sum()

    def node_at(self, place: tuple[float, float, float]) -> int:
        """The node at a place. @throws ValueError"""
        distance = np.linalg.norm(self.rest - np.array(place), axis=1)
        if distance.min() > 1e-9:
            raise ValueError(f"no node at {place}, the nearest is {distance.min():.3g} m away")
        return int(distance.argmin())
