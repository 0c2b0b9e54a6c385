# SPDX-License-Identifier: GPL-3.0-or-later
"""The canopy and the flow around it: VTK draws the pixels, matplotlib the scales. Lengths and values are in the units
of the case; z points up."""
import pathlib

import matplotlib.pyplot as plt
import numpy as np
import vtk
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

from result_files import NothingToDraw, latest, read_vtu

STRESS, FLOW = "inferno", "viridis"
PIXELS = (1000, 1200)
DARK = (0.15, 0.15, 0.15)


def cells_of_dimension(grid, dimension: int):
    """The cells of one dimension as a surface or lines that VTK can draw."""
    kinds = vtk_to_numpy(grid.GetCellTypesArray())
    dimensions = {kind: vtk.vtkGenericCell.InstantiateCell(int(kind)).GetCellDimension() for kind in np.unique(kinds)}
    wanted = vtk.vtkIdList()
    for cell in np.flatnonzero([dimensions[kind] == dimension for kind in kinds]):
        wanted.InsertNextId(int(cell))
    extract = vtk.vtkExtractCells()
    extract.SetInputData(grid)
    extract.SetCellList(wanted)
    surface = vtk.vtkDataSetSurfaceFilter()
    surface.SetInputConnection(extract.GetOutputPort())
    surface.SetNonlinearSubdivisionLevel(2)
    surface.Update()
    return surface.GetOutput()


def colour_table(name: str, scale: Normalize):
    table = vtk.vtkLookupTable()
    table.SetNumberOfTableValues(256)
    for i, colour in enumerate(plt.get_cmap(name)(np.linspace(0, 1, 256))):
        table.SetTableValue(i, *colour)
    table.SetRange(scale.vmin, scale.vmax)
    return table


def add(renderer, data, values=None, table=None, colour=DARK, width=1.0, lighting=True):
    """Adds a data set, coloured by the point data `values` or in one colour."""
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputData(data)
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*colour)
    actor.GetProperty().SetLineWidth(width)
    actor.GetProperty().SetLighting(lighting)
    if values is None:
        mapper.ScalarVisibilityOff()
    else:
        mapper.SetScalarModeToUsePointFieldData()
        mapper.SelectColorArray(values)
        mapper.SetLookupTable(table)
        mapper.UseLookupTableScalarRangeOn()
        mapper.InterpolateScalarsBeforeMappingOn()
    renderer.AddActor(actor)
    return actor


def pixels(renderer, size=PIXELS) -> np.ndarray:
    renderer.SetBackground(1, 1, 1)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(8)
    window.SetSize(*size)
    window.AddRenderer(renderer)
    window.Render()
    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    grab.Update()
    image = grab.GetOutput()
    width, height, _ = image.GetDimensions()
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, 3)[::-1]


def look(renderer, centre, direction, half_height):
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetFocalPoint(*centre)
    camera.SetPosition(*(np.asarray(centre) + np.asarray(direction) * 10 * half_height))
    camera.SetViewUp(0, 0, 1)
    camera.SetParallelScale(half_height)
    renderer.ResetCameraClippingRange()


def box(data) -> np.ndarray:
    """Shape {3, 2}: lowest and highest coordinate along each axis."""
    return np.array(data.GetBounds()).reshape(3, 2)


def scale_of(data, name: str) -> Normalize:
    values = vtk_to_numpy(data.GetPointData().GetArray(name))
    values = values[np.isfinite(values)]
    if values.size == 0:
        raise NothingToDraw(f"{name} has no finite value")
    low, high = np.percentile(values, (1, 99))
    return Normalize(min(low, 0.0), high if high > low else low + 1.0)


def common_boxes(files: list[pathlib.Path]) -> tuple[np.ndarray, np.ndarray]:
    """Boxes around the cloth, and around all, of several states of a structure; shape {3, 2} each."""
    grids = [read_vtu(file) for file in files]
    boxes = np.array([[box(cells_of_dimension(grid, 2)), box(grid)] for grid in grids])
    return tuple(np.stack((boxes[:, i, :, 0].min(axis=0), boxes[:, i, :, 1].max(axis=0)), axis=1) for i in range(2))


def draw_structure(file: pathlib.Path, axes, window: np.ndarray | None = None):
    """@param window: box to show; default: the structure's own"""
    grid = read_vtu(file)
    cloth, lines = cells_of_dimension(grid, 2), cells_of_dimension(grid, 1)
    renderer = vtk.vtkRenderer()
    scale = None
    if cloth.GetPointData().HasArray("principal_stress_1"):
        scale = scale_of(cloth, "principal_stress_1")
        normals = vtk.vtkPolyDataNormals()
        normals.SetInputData(cloth)
        normals.SplittingOff()
        normals.Update()
        actor = add(renderer, normals.GetOutput(), "principal_stress_1", colour_table(STRESS, scale))
        actor.GetProperty().SetAmbient(0.35)
        actor.GetProperty().SetDiffuse(0.7)
    else:
        add(renderer, cloth, colour=(0.9, 0.6, 0.2))
    if lines.GetNumberOfCells():
        add(renderer, lines, width=2, lighting=False)
    bounds = box(grid) if window is None else window
    renderer.AutomaticLightCreationOn()
    look(renderer, bounds.mean(axis=1), direction(azimuth=25, elevation=18), half_height=0.56 * np.ptp(bounds[2]) + 1e-12)
    show(axes, pixels(renderer), scale, STRESS, "largest principal stress (unit of the case)", "Canopy and lines")


def direction(azimuth: float, elevation: float) -> np.ndarray:
    a, e = np.radians((azimuth, elevation))
    return np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])


def cut(data, centre):
    """The cut through a data set at x = x of `centre`."""
    plane = vtk.vtkPlane()
    plane.SetOrigin(*centre)
    plane.SetNormal(1, 0, 0)
    cutter = vtk.vtkCutter()
    cutter.SetInputData(data)
    cutter.SetCutFunction(plane)
    cutter.Update()
    return cutter.GetOutput()


def edges_of(data):
    edges = vtk.vtkExtractEdges()
    edges.SetInputData(data)
    edges.Update()
    return edges.GetOutput()


def draw_flow(file: pathlib.Path, structure: pathlib.Path | None, axes, window: np.ndarray | None = None):
    """@param window: box around the cloth that the view goes by; default: the cloth's own"""
    grid = read_vtu(file)
    speed = np.linalg.norm(vtk_to_numpy(grid.GetPointData().GetArray("velocity")), axis=1)
    array = numpy_to_vtk(speed, deep=True)
    array.SetName("speed")
    grid.GetPointData().AddArray(array)
    cloth = cells_of_dimension(read_vtu(structure), 2) if structure else None
    bounds = window if window is not None else box(cloth if cloth else grid)
    centre = bounds.mean(axis=1)
    # A little off the centre, so that the plane does not run along edges of a symmetric mesh.
    centre[0] += 1e-3 * np.ptp(bounds[0])
    if cloth:
        height = 2.9 * np.ptp(bounds[1])
        centre[2] = bounds[2, 0] + 0.30 * height
    else:
        height = np.ptp(bounds[2])

    section = cut(grid, centre)
    if section.GetNumberOfCells() == 0:
        raise NothingToDraw(f"the plane through the canopy does not meet the mesh of {file}")
    scale = scale_of(section, "speed")
    renderer = vtk.vtkRenderer()
    add(renderer, section, "speed", colour_table(FLOW, scale), lighting=False)
    mesh = add(renderer, edges_of(section), colour=(1, 1, 1), width=1, lighting=False)
    mesh.GetProperty().SetOpacity(0.18)
    mesh.AddPosition(5e-3 * height, 0, 0)  # before the section, the cloth before both
    if cloth:
        outline = add(renderer, cut(cloth, centre), colour=(0.95, 0.2, 0.15), width=5, lighting=False)
        outline.AddPosition(1e-2 * height, 0, 0)
    look(renderer, centre, (1, 0, 0), height / 2)
    show(axes, pixels(renderer), scale, FLOW, "flow speed (unit of the case)",
         "Flow in the plane through the axis")


def show(axes, image, scale, colours, label, title):
    axes.imshow(image, interpolation="lanczos")
    axes.set_axis_off()
    axes.set_title(title)
    if scale is not None:
        bar = axes.figure.colorbar(ScalarMappable(scale, colours), ax=axes, orientation="horizontal", pad=0.02,
                                   shrink=0.75, aspect=30)
        bar.set_label(label)
        bar.outline.set_visible(False)


def canopy(run: pathlib.Path):
    """The last canopy, coloured by stress, beside the last flow field in a vertical plane."""
    found, missing = {}, []
    for part in ("structure", "fluid"):
        try:
            found[part] = latest(run, f"{part}_*.*vtu")
        except NothingToDraw as reason:
            missing.append(str(reason))
    if not found:
        raise NothingToDraw("; ".join(missing))
    figure, axes = plt.subplots(1, len(found), figsize=(5.6 * len(found), 7.6), squeeze=False)
    panels = iter(axes[0])
    if "structure" in found:
        draw_structure(found["structure"], next(panels))
    if "fluid" in found:
        draw_flow(found["fluid"], found.get("structure"), next(panels))
    figure.tight_layout()
    return figure
