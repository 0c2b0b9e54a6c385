# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a fluid mesh (.msh) as Drogue's own programs do: nodes and elements in the order of their tags, blocks of one
group and kind in the order of their first element."""

import numpy as np

NODES = {15: 1, 1: 2, 2: 3, 3: 4, 4: 4, 8: 3, 9: 6, 10: 9}  # nodes of an element by Gmsh's type
TRIANGLE = 2
FNV_OFFSET, FNV_PRIME, FNV_MASK = 14695981039346656037, 1099511628211, (1 << 64) - 1


class FluidMesh:
    """points {N, 3}; blocks: list of (group, Gmsh's element type, int32 nodes {m, nodes of an element})."""

    def __init__(self, file):
        import gmsh  # Debian: python3-gmsh

        gmsh.initialize([], False)
        try:
            gmsh.option.setNumber("General.Terminal", 0)
            gmsh.option.setNumber("Mesh.Renumber", 0)
            gmsh.merge(file)
            tags, coordinates, _ = gmsh.model.mesh.getNodes()
            order = np.argsort(tags, kind="stable")
            self._tags = tags[order]
            self.points = coordinates.reshape(-1, 3)[order]
            self.blocks = self._read_blocks(gmsh)
            self.material = self._read_material(gmsh)
        finally:
            gmsh.finalize()

    def triangles(self, groups):
        """Triangles of some groups in mesh order {m, 3}."""
        found = [nodes for group, kind, nodes in self.blocks if group in groups and kind == TRIANGLE]
        return np.concatenate(found) if found else np.empty((0, 3), np.int32)

    def nodes(self, groups):
        """Sorted, unique nodes of some groups."""
        return np.unique(self.triangles(groups))

    def groups(self):
        return [group for group, _, _ in self.blocks]

    def hash(self):
        """FNV-1a over points, and group names and nodes of every block: what mesh_mover and fluid_solver show."""
        data = [np.ascontiguousarray(self.points, "<f8").tobytes()]
        for group, _, nodes in self.blocks:
            data += [group.encode(), np.ascontiguousarray(nodes, "<i4").tobytes()]
        state = FNV_OFFSET
        for chunk in data:
            for byte in chunk:
                state = ((state ^ byte) * FNV_PRIME) & FNV_MASK
        return f"{state:016x}"

    def _read_blocks(self, gmsh):
        raw = {}
        for dimension, group in gmsh.model.getPhysicalGroups():
            name = gmsh.model.getPhysicalName(dimension, group)
            for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, group):
                for kind, elements, nodes in zip(*gmsh.model.mesh.getElements(dimension, entity)):
                    pair = raw.setdefault((name, int(kind)), ([], []))
                    pair[0].append(elements)
                    pair[1].append(nodes)
        blocks = []
        for (name, kind), (elements, nodes) in raw.items():
            elements = np.concatenate(elements)
            nodes = np.searchsorted(self._tags, np.concatenate(nodes)).reshape(-1, NODES[kind])
            blocks.append((elements.min(), name, kind, nodes[np.argsort(elements, kind="stable")].astype(np.int32)))
        blocks.sort(key=lambda block: block[0])
        return [block[1:] for block in blocks]

    def _read_material(self, gmsh):
        """The node field "material" {N, 3} in which surfaces are matched, or None."""
        for view in gmsh.view.getTags():
            index = gmsh.view.getIndex(view)
            if gmsh.option.getString(f"View[{index}].Name") != "material":
                continue
            _, tags, values, _, components = gmsh.view.getHomogeneousModelData(view, 0)
            material = np.full((len(self.points), components), np.nan)
            material[np.searchsorted(self._tags, tags)] = np.reshape(values, (-1, components))
            return material if components == 3 else None
        return None
