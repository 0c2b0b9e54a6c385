# SPDX-License-Identifier: GPL-3.0-or-later
"""One canopy of every family (called by scripts/canopies): canopies.py inflate BIN_DIR FOLDER makes the structure meshes and
inflates them, canopies.py draw FOLDER FILE draws them."""
import pathlib
import subprocess
import sys

# Constructed diameter 35 ft, the cloth and cables of the T-10 (feet, slug, seconds, pounds).
FLAT = "vent_ratio: 0.1 skirt_ratio: 0 gores: 16"
ROWS = "element: Q4 main_rows: 10 across_vent: 2 across_seam: 2 across_skirt: 2"
FAMILIES = {
    "flat circular": (FLAT, "vent_elements: 3", ROWS + " skirt_rows: 0"),
    "flat extended skirt": ("vent_ratio: 0.1 skirt_ratio: 0.1 gores: 16", "vent_elements: 3", ROWS + " skirt_rows: 2"),
    "conical": ("shape: CONICAL cone_angle: 30 vent_ratio: 0.1 skirt_ratio: 0 gores: 16", "vent_elements: 3",
                ROWS + " skirt_rows: 0"),
    "hemispherical": ("shape: HEMISPHERICAL vent_ratio: 0.1 skirt_ratio: 0 gores: 16", "vent_elements: 3",
                      ROWS + " skirt_rows: 0"),
    "annular": ("vent_ratio: 0.5 skirt_ratio: 0 gores: 16", "vent_elements: 0 inner_line_elements: 10",
                ROWS + " skirt_rows: 0"),
    "ringslot": (FLAT + " gap { from: 0.4 to: 0.44 } gap { from: 0.6 to: 0.63 } gap { from: 0.8 to: 0.82 }",
                 "vent_elements: 3", ROWS + " skirt_rows: 0"),
    "cross": ("shape: CROSS arm_width_ratio: 0.3 lines_per_arm: 4", "", "element: Q4 main_rows: 9 across_seam: 6"),
}
# A flat ring alone folds up under a constant pressure; in a flow it is held open.
HELD = {"annular": "support { group: 'skirt_edge' components: 'xy' }\n"}
GROUPS = ("suspension_lines", "radials", "vent_lines", "inner_lines")


def run(program: pathlib.Path, *arguments: str, folder: pathlib.Path) -> None:
    done = subprocess.run([program, *arguments], cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{program.name} {' '.join(arguments)} in {folder}: {done.stdout}{done.stderr}")


def groups_of(bin_dir: pathlib.Path, mesh: pathlib.Path) -> str:
    return subprocess.run([bin_dir / "parachute_mesher", "info", mesh], capture_output=True, text=True, check=True).stdout


def inflate(bin_dir: pathlib.Path, work: pathlib.Path) -> None:
    for name, (canopy, rigging, structure) in FAMILIES.items():
        folder = work / name.replace(" ", "_")
        folder.mkdir(parents=True)
        (folder / "parachute.textproto").write_text(
            f"canopy {{ diameter: 35 {canopy} }}\n"
            f"rigging {{ line_length: 29.4 line_elements: 10 confluence_distance: 2.3 {rigging} }}\n"
            f"structure {{ file: 'structure.msh' {structure} }}\n")
        run(bin_dir / "parachute_mesher", "structure", "parachute.textproto", folder=folder)
        groups = groups_of(bin_dir, folder / "structure.msh")
        cables = "".join(f"cable {{ group: '{group}' area: 0.0001 density: 6.0 youngs_modulus: 4.32e6 }}\n"
                         for group in GROUPS if group in groups)
        (folder / "inflation.textproto").write_text(
            "mesh: 'structure.msh'\n"
            "membrane { group: 'canopy' thickness: 0.0001 density: 6.0 youngs_modulus: 2.0e5 poisson_ratio: 0.3 }\n"
            + cables + "support { group: 'confluence' }\n" + HELD.get(name, "") +
            "pressure { group: 'canopy' value: '0.5' }\n"
            "time { step: 0.04 steps: 50 rho_infinity: 0 mass_damping: 20 }\n"
            "newton { displacement_tolerance: 1e-4 max_iterations: 12 }\n"
            "output { directory: 'inflation' field_interval: 100000 }\n")
        run(bin_dir / "structure_solver", "run", "inflation.textproto", folder=folder)
        print(f"    {name}")


def draw(work: pathlib.Path, file: pathlib.Path) -> None:
    import matplotlib.pyplot as plt
    import vtk

    import field_pictures as pictures
    from result_files import latest, read_vtu

    figure, axes = plt.subplots(2, 4, figsize=(15, 9.5), dpi=100)
    for axis in axes.flat:
        axis.set_axis_off()
    for axis, name in zip(axes.flat, FAMILIES):
        grid = read_vtu(latest(work / name.replace(" ", "_"), "*.vtu"))
        cloth, lines = pictures.cells_of_dimension(grid, 2), pictures.cells_of_dimension(grid, 1)
        normals = vtk.vtkPolyDataNormals()
        normals.SetInputData(cloth)
        normals.SplittingOff()
        normals.Update()
        renderer = vtk.vtkRenderer()
        actor = pictures.add(renderer, normals.GetOutput(), colour=(0.93, 0.62, 0.22))
        actor.GetProperty().SetAmbient(0.3)
        actor.GetProperty().SetDiffuse(0.75)
        pictures.add(renderer, lines, width=1.5, lighting=False)
        bounds = pictures.box(grid)
        renderer.AutomaticLightCreationOn()
        pictures.look(renderer, bounds.mean(axis=1), pictures.direction(azimuth=25, elevation=22), half_height=24)
        pictures.show(axis, pictures.pixels(renderer, (700, 900)), None, None, None, name)
    figure.tight_layout()
    figure.savefig(file, bbox_inches="tight")


if __name__ == "__main__":
    command, first, second = sys.argv[1], *map(pathlib.Path, sys.argv[2:4])
    {"inflate": inflate, "draw": draw}[command](first, second)
