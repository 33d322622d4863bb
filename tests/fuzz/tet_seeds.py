# SPDX-License-Identifier: Apache-2.0
"""Files of tetrahedra, and the words of their formats."""

from __future__ import annotations

import base64
import struct
import zlib
from typing import Any

import numpy as np

TET_WORDS = ("$MeshFormat $EndMeshFormat $Entities $EndEntities $Nodes $EndNodes $Elements "
             "$EndElements 2.2 4.1 ASCII BINARY DATASET UNSTRUCTURED_GRID POINTS CELLS OFFSETS "
             "CONNECTIVITY CELL_TYPES CELL_DATA SCALARS LOOKUP_TABLE FIELD METADATA double float "
             "int vtktypeint64 <VTKFile UnstructuredGrid <UnstructuredGrid> <Piece NumberOfCells= "
             "NumberOfPoints= <Points> </Points> <Cells> </Cells> <CellData> <DataArray "
             "</DataArray> type= Name= NumberOfComponents= format= offset= ascii binary appended "
             "Float64 Int32 UInt8 connectivity offsets types region byte_order=\"BigEndian\" "
             "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\" <AppendedData "
             "encoding= raw base64 /> <!-- -->").split()


def msh_seeds() -> list[bytes]:
    """Two tetrahedra as MSH, as text and as bytes."""
    points, tets = np.eye(5, 3), np.array([[1, 2, 3, 4], [2, 1, 3, 5]])
    points[3], points[4] = (1, 1, 1), (-1, -1, -1)
    end = b"$EndMeshFormat\n"
    nodes = "".join(f"{k + 1} {x} {y} {z}\n" for k, (x, y, z) in enumerate(points))
    elements = "".join(f"{k + 1} 4 2 7 {k} " + " ".join(map(str, t)) + "\n"
                       for k, t in enumerate(tets))
    text2 = (b"$MeshFormat\n2.2 0 8\n" + end
             + f"$Nodes\n5\n{nodes}$EndNodes\n$Elements\n2\n{elements}$EndElements\n".encode())
    bytes2 = (b"$MeshFormat\n2.2 1 8\n" + struct.pack("<i", 1) + b"\n" + end + b"$Nodes\n5\n"
              + b"".join(struct.pack("<i3d", k + 1, *x) for k, x in enumerate(points))
              + b"\n$EndNodes\n$Elements\n2\n" + struct.pack("<3i", 4, 2, 2)
              + b"".join(struct.pack("<7i", k + 1, 7, k, *t) for k, t in enumerate(tets))
              + b"\n$EndElements\n")
    entity = struct.pack("<4Qi6dQiQi", 0, 0, 0, 1, 3, *range(6), 1, 7, 1, -2)
    bytes4 = (b"$MeshFormat\n4.1 1 8\n" + struct.pack("<i", 1) + b"\n" + end + b"$Entities\n"
              + entity + b"\n$EndEntities\n$Nodes\n" + struct.pack("<4Q3iQ", 1, 5, 1, 5, 3, 3, 0, 5)
              + np.arange(1, 6).astype("<u8").tobytes() + points.tobytes()
              + b"\n$EndNodes\n$Elements\n" + struct.pack("<4Q3iQ", 1, 2, 1, 2, 3, 3, 4, 2)
              + b"".join(struct.pack("<5Q", k + 1, *t) for k, t in enumerate(tets))
              + b"\n$EndElements\n")
    return [text2, bytes2, bytes4]


def vtk_seeds() -> list[bytes]:
    """A tetrahedron as legacy VTK of both versions."""
    points, corners = np.eye(4, 3)[[3, 0, 1, 2]], np.arange(4)
    old = ("# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n"
           + " ".join(map(str, points.ravel())) + "\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n"
           "CELL_DATA 1\nSCALARS material int 1\nLOOKUP_TABLE default\n3\n")
    new = (b"# vtk DataFile Version 5.1\n\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n"
           + points.astype(">f8").tobytes() + b"\nCELLS 2 4\nOFFSETS vtktypeint64\n"
           + np.array([0, 4], ">i8").tobytes() + b"\nCONNECTIVITY vtktypeint64\n"
           + corners.astype(">i8").tobytes() + b"\nCELL_TYPES 1\n" + np.array(10, ">i4").tobytes()
           + b"\nCELL_DATA 1\nFIELD FieldData 1\nregion 1 1 int\n" + bytes(4) + b"\n")
    return [old.encode(), new]


def vtu_seed(form: str, packed: bool) -> bytes:
    """A tetrahedron as VTU; `form` is ascii, binary, raw or base64, the last two appended."""
    appended = b""

    def array(name: str, kind: str, values: Any, more: str = "") -> str:
        nonlocal appended
        raw = values.tobytes()
        data = zlib.compress(raw) if packed else raw
        count = (struct.pack("<4I", 1, len(raw), 0, len(data)) if packed
                 else struct.pack("<I", len(raw)))
        coded = (base64.b64encode(count) + base64.b64encode(data) if packed
                 else base64.b64encode(count + data))
        text, format_of = "", form
        if form == "ascii":
            text = " ".join(map(str, values.ravel().tolist()))
        elif form == "binary":
            text = coded.decode()
        else:
            format_of, more = "appended", f'{more} offset="{len(appended)}"'
            appended += count + data if form == "raw" else coded
        return (f'<DataArray type="{kind}" Name="{name}" format="{format_of}" {more}>{text}'
                "</DataArray>\n")

    head = ('<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" byte_order="LittleEndian"'
            + (' compressor="vtkZLibDataCompressor"' if packed else "") + ">\n<UnstructuredGrid>\n"
            '<Piece NumberOfPoints="4" NumberOfCells="1">\n<Points>\n'
            + array("Points", "Float64", np.eye(4, 3)[[3, 0, 1, 2]], 'NumberOfComponents="3"')
            + "</Points>\n<Cells>\n" + array("connectivity", "Int32", np.arange(4, dtype="<i4"))
            + array("offsets", "Int32", np.array([4], "<i4"))
            + array("types", "UInt8", np.array([10], "u1")) + "</Cells>\n<CellData>\n"
            + array("region", "Int32", np.array([5], "<i4"))
            + "</CellData>\n</Piece>\n</UnstructuredGrid>\n")
    tail = f'<AppendedData encoding="{form}">\n_'.encode() + appended + b"\n</AppendedData>\n"
    return head.encode() + (tail if appended else b"") + b"</VTKFile>\n"


def tet_seeds() -> list[bytes]:
    """One file of each format and encoding."""
    return [*msh_seeds(), *vtk_seeds(), vtu_seed("ascii", False),
            *(vtu_seed(form, packed) for form in ("binary", "raw", "base64")
              for packed in (False, True))]
