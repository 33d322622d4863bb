# SPDX-License-Identifier: Apache-2.0
"""VTK: the GLB by vtkGLTFReader with deformations applied. (vtkGLTFImporter, by which F3D draws,
deforms in a shader of its own: see f3d_glb.py.)

Each frame has a reader of its own: asked for a second time, that of VTK 9.7.2 gives the last
primitive of a mesh in place of the first."""

from __future__ import annotations

from collections.abc import Iterator

import vtk
from vtk.util.numpy_support import vtk_to_numpy

from client_job import Answer, Job, Values, load_job


def blocks(data: vtk.vtkMultiBlockDataSet) -> Iterator[Values]:
    """Positions of each primitive in the tree."""
    for index in range(data.GetNumberOfBlocks()):
        block = data.GetBlock(index)
        if block is None:
            continue
        if block.IsA("vtkMultiBlockDataSet"):
            yield from blocks(block)
        elif block.GetNumberOfPoints():
            yield vtk_to_numpy(block.GetPoints().GetData())


def reader_of(job: Job) -> vtk.vtkGLTFReader:
    """A reader with all animations on."""
    reader = vtk.vtkGLTFReader()
    reader.SetFileName(job.glb)
    reader.ApplyDeformationsToGeometryOn()
    reader.UpdateInformation()
    for index in range(reader.GetNumberOfAnimations()):
        reader.EnableAnimation(index)
    reader.SetFrameRate(job.fps)
    reader.UpdateInformation()
    return reader


def main() -> None:
    """Reads the file at each time and answers."""
    job, _ = load_job()
    answer = Answer(vtk.vtkVersion.GetVTKVersion())
    for frame in job.frames:
        reader = reader_of(job)
        reader.UpdateTimeStep(job.seconds(frame))
        for positions in blocks(reader.GetOutput()):
            answer.show(frame, positions)
    answer.save(job)


if __name__ == "__main__":
    main()
