// SPDX-License-Identifier: Apache-2.0
// Small files of the formats that assimp reads. All hold one tetrahedron with the corners 0, x, 2y,
// 3z of the file's own axes: volume 1 in its own unit, edges of different lengths along each axis.

#pragma once

#include "core/error.hpp"

#include <cstdint>
#include <string>

namespace elastogen::test {

/// FBX 7.4 text. @param up  0 x, 1 y, 2 z. @param unit  centimetres.
inline std::string fbx_text(int up, double unit) {
  return concat(
      "; FBX 7.4.0 project file\nFBXHeaderExtension:  {\n FBXHeaderVersion: 1003\n"
      " FBXVersion: 7400\n}\nGlobalSettings:  {\n Version: 1000\n Properties70:  {\n"
      "  P: \"UpAxis\", \"int\", \"Integer\", \"\",",
      up, "\n  P: \"UpAxisSign\", \"int\", \"Integer\", \"\",1\n",
      "  P: \"UnitScaleFactor\", \"double\", \"Number\", \"\",", unit,
      "\n }\n}\nObjects:  {\n Geometry: 1000, \"Geometry::wedge\", \"Mesh\" {\n"
      "  Vertices: *12 {\n   a: 0,0,0,1,0,0,0,2,0,0,0,3\n  }\n"
      "  PolygonVertexIndex: *12 {\n   a: 0,2,-2,0,1,-4,0,3,-3,1,2,-4\n  }\n"
      "  GeometryVersion: 124\n }\n Model: 2000, \"Model::wedge\", \"Mesh\" {\n  Version: 232\n"
      " }\n}\nConnections:  {\n C: \"OO\",2000,0\n C: \"OO\",1000,2000\n}\n");
}

/// Parts of a DAE file that differ from the usual.
struct DaeOptions {
  std::string doctype;  ///< before the root element
  std::string unit = "1", up = "Y_UP";
  std::string texture;                 ///< file of the diffuse colour
  std::string count = "12";            ///< of numbers in the array of positions
  std::string nodes_begin, nodes_end;  ///< around the node that shows the mesh
};

inline std::string dae_material(const std::string& texture) {
  if (texture.empty()) return "";
  return "<library_images><image id='i'><init_from>" + texture +
         "</init_from></image></library_images><library_effects><effect id='e'><profile_COMMON>"
         "<newparam sid='s'><surface type='2D'><init_from>i</init_from></surface></newparam>"
         "<newparam sid='t'><sampler2D><source>s</source></sampler2D></newparam>"
         "<technique sid='c'><lambert><diffuse><texture texture='t' texcoord='U'/></diffuse>"
         "</lambert></technique></profile_COMMON></effect></library_effects><library_materials>"
         "<material id='m'><instance_effect url='#e'/></material></library_materials>";
}

inline std::string dae_text(const DaeOptions& o = {}) {
  // a texture needs its material bound to the mesh
  const std::string bind = o.texture.empty()
                               ? ""
                               : "<bind_material><technique_common><instance_material symbol='M' "
                                 "target='#m'/></technique_common></bind_material>";
  // asset, material, geometry and the node that shows it
  return "<?xml version='1.0'?>" + o.doctype +
         "<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'><asset>"
         "<unit name='u' meter='" +
         o.unit + "'/><up_axis>" + o.up + "</up_axis></asset>" + dae_material(o.texture) +
         "<library_geometries><geometry id='g' name='wedge'><mesh><source id='p'>"
         "<float_array id='a' count='" +
         o.count +
         "'>0 0 0 1 0 0 0 2 0 0 0 3</float_array><technique_common>"
         "<accessor source='#a' count='4' stride='3'><param name='X' type='float'/>"
         "<param name='Y' type='float'/><param name='Z' type='float'/></accessor>"
         "</technique_common></source><vertices id='v'><input semantic='POSITION' source='#p'/>"
         "</vertices><triangles count='4' material='M'>"
         "<input semantic='VERTEX' source='#v' offset='0'/>"
         "<p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles></mesh></geometry></library_geometries>"
         "<library_visual_scenes><visual_scene id='s'>" +
         o.nodes_begin + "<node id='n'><instance_geometry url='#g'>" + bind +
         "</instance_geometry></node>" + o.nodes_end +
         "</visual_scene></library_visual_scenes><scene><instance_visual_scene url='#s'/></scene>"
         "</COLLADA>";
}

/// DirectX text: left-handed, clockwise seen from outside.
inline std::string x_text() {
  return "xof 0303txt 0032\nMesh wedge {\n 4;\n 0;0;0;,\n 1;0;0;,\n 0;2;0;,\n 0;0;-3;;\n 4;\n"
         " 3;0,1,2;,\n 3;0,3,1;,\n 3;0,2,3;,\n 3;1,3,2;;\n}\n";
}

inline std::string ac_text() {
  return "AC3Db\nMATERIAL \"red\" rgb 1 0 0  amb 0 0 0  emis 0 0 0  spec 0 0 0  shi 1  trans 0\n"
         "OBJECT world\nkids 1\nOBJECT poly\nname \"wedge\"\nnumvert 4\n0 0 0\n1 0 0\n0 2 0\n0 0 "
         "3\n"
         "numsurf 4\nSURF 0x0\nmat 0\nrefs 3\n0 0 0\n2 0 0\n1 0 0\nSURF 0x0\nmat 0\nrefs 3\n"
         "0 0 0\n1 0 0\n3 0 0\nSURF 0x0\nmat 0\nrefs 3\n0 0 0\n3 0 0\n2 0 0\nSURF 0x0\nmat 0\n"
         "refs 3\n1 0 0\n2 0 0\n3 0 0\nkids 0\n";
}

/// A chunk of 3DS.
inline std::string chunk(uint16_t id, const std::string& content) {
  const auto size = uint32_t(6 + content.size());
  return std::string(reinterpret_cast<const char*>(&id), 2) +
         std::string(reinterpret_cast<const char*>(&size), 4) + content;
}

inline std::string three_ds_bytes() {
  const float position[] = {0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3};
  const uint16_t face[] = {0, 2, 1, 0, 0, 1, 3, 0, 0, 3, 2, 0, 1, 2, 3, 0}, four = 4;
  const std::string count(reinterpret_cast<const char*>(&four), 2);
  const std::string points(reinterpret_cast<const char*>(position), sizeof(position));
  const std::string faces(reinterpret_cast<const char*>(face), sizeof(face));
  const std::string mesh =
      chunk(0x4100, chunk(0x4110, count + points) + chunk(0x4120, count + faces));
  return chunk(0x4d4d, chunk(0x3d3d, chunk(0x4000, std::string("wedge\0", 6) + mesh)));
}

}  // namespace elastogen::test
