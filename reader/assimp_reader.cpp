// SPDX-License-Identifier: Apache-2.0
#include "reader/assimp_reader.hpp"

#include "core/error.hpp"
#include "io/asset_check.hpp"
#include "io/polygon.hpp"
#include "io/safe_file.hpp"

#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/importerdesc.h>
#include <assimp/material.h>
#include <assimp/scene.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <new>
#include <sstream>
#include <stdexcept>

namespace elastogen {
namespace {

/// Opens no files: our importers need none beside the asset, which is read beforehand.
class ClosedSystem : public Assimp::IOSystem {
 public:
  bool Exists(const char*) const override { return false; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char*, const char*) override { return nullptr; }
  void Close(Assimp::IOStream*) override {}
};

std::string text_of(const aiString& s) {
  return std::string(s.data, std::min<size_t>(s.length, sizeof(s.data)));
}

/// Removes all importers but the one of the format.
void keep_importer(Assimp::Importer& importer, const std::string& format) {
  for (size_t k = importer.GetImporterCount(); k-- > 0;) {
    std::istringstream endings(importer.GetImporterInfo(k)->mFileExtensions);
    bool ours = false;
    for (std::string ending; endings >> ending;) ours = ours || ending == format;
    if (!ours) importer.UnregisterLoader(importer.GetImporter(k));
  }
}

/// @throws std::bad_alloc if the importer ran out of memory, else Error (asset) with its message.
[[noreturn]] void throw_reason(const Assimp::Importer& importer) {
  try {
    if (importer.GetException()) std::rethrow_exception(importer.GetException());
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::length_error&) {  // a container larger than any memory
    throw std::bad_alloc();
  } catch (const std::exception&) {
    // its message is that of the importer
  }
  const std::string text = importer.GetErrorString();
  if (text.find("unsupported, old format version") != text.npos)
    throw Error("FBX older than 7.1; re-save it as FBX 7.4 binary or glTF", ErrorKind::kAsset);
  throw Error(text.empty() ? "the importer gives no reason" : text, ErrorKind::kAsset);
}

/// A number of the scene's metadata, of any type.
double number(const aiScene& scene, const char* key, double otherwise) {
  if (!scene.mMetaData) return otherwise;
  double real = 0;
  float single = 0;
  int32_t whole = 0;
  if (scene.mMetaData->Get(key, real)) return real;
  if (scene.mMetaData->Get(key, single)) return single;
  if (scene.mMetaData->Get(key, whole)) return whole;
  return otherwise;
}

/// Converts a scene of assimp to an Asset.
class Conversion {
 public:
  Conversion(const aiScene& scene, Asset& asset) : scene_(scene), asset_(asset) {}

  void run() {
    add_axes();
    for (unsigned k = 0; k < scene_.mNumMaterials; ++k) add_material(*scene_.mMaterials[k]);
    add_nodes();
    add_finding(asset_, "animations", scene_.mNumAnimations, "the file has animations of its own");
  }

 private:
  void add_axes();
  void add_material(const aiMaterial& from);
  void add_nodes();
  void add_node(const aiNode& from, int parent);
  int mesh(unsigned index);
  void add_vertices(const aiMesh& from, Mesh& mesh);
  void add_faces(const aiMesh& from, Mesh& mesh);

  const aiScene& scene_;
  Asset& asset_;
  std::map<unsigned, int> mesh_of_;  ///< index in the asset of each shown mesh
};

void Conversion::add_axes() {
  asset_.up = 2;
  if (asset_.format == "dae") asset_.unit = 1;
  if (asset_.format != "fbx") return;
  const double axis = number(scene_, "UpAxis", 1), sign = number(scene_, "UpAxisSign", 1);
  if (axis == 0 || axis == 1 || axis == 2) asset_.up = (int(axis) + 1) * (sign < 0 ? -1 : 1);
  const double centimetres = number(scene_, "UnitScaleFactor", 1);
  if (std::isfinite(centimetres) && centimetres > 0) asset_.unit = centimetres / 100;
}

void Conversion::add_material(const aiMaterial& from) {
  AssetMaterial& material = asset_.materials.emplace_back();
  aiString name;
  if (from.Get(AI_MATKEY_NAME, name) == aiReturn_SUCCESS) material.name = text_of(name);
  aiColor4D c;
  const bool coloured = from.Get(AI_MATKEY_BASE_COLOR, c) == aiReturn_SUCCESS ||
                        from.Get(AI_MATKEY_COLOR_DIFFUSE, c) == aiReturn_SUCCESS;
  if (coloured) material.base_colour = {c.r, c.g, c.b, 1};
  float opacity = 1;
  if (from.Get(AI_MATKEY_OPACITY, opacity) == aiReturn_SUCCESS) material.base_colour[3] = opacity;
  for (float& x : material.base_colour) x = std::isfinite(x) ? std::clamp(x, 0.f, 1.f) : 1;

  aiString texture;
  for (const aiTextureType type : {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE})
    if (texture.length == 0) from.GetTexture(type, 0, &texture);
  if (texture.length == 0) return;
  material.texture = text_of(texture);
  if (!scene_.GetEmbeddedTexture(material.texture.c_str())) return;
  material.texture.clear();
  add_finding(asset_, "embedded-texture", 1, "textures lie within the file");
}

void Conversion::add_nodes() {
  // depth first but not recursive, because the file decides the depth
  struct Visit {
    const aiNode* node;
    int parent;
  };
  std::vector<Visit> open = {{scene_.mRootNode, -1}};
  while (!open.empty()) {
    const Visit visit = open.back();
    open.pop_back();
    const int index = int(asset_.nodes.size());
    add_node(*visit.node, visit.parent);
    for (unsigned k = visit.node->mNumChildren; k-- > 0;)
      open.push_back({visit.node->mChildren[k], index});
  }
}

/// Adds a node with its first mesh; further meshes become children.
void Conversion::add_node(const aiNode& from, int parent) {
  const aiMatrix4x4& m = from.mTransformation;
  const int index = int(asset_.nodes.size());
  AssetNode& node = asset_.nodes.emplace_back();
  node.name = text_of(from.mName);
  node.parent = parent;
  for (unsigned row = 0; row < 4; ++row)
    for (unsigned column = 0; column < 4; ++column)
      node.matrix[4 * column + row] = double(m[row][column]);
  for (unsigned k = 0; k < from.mNumMeshes; ++k) {
    const int shown = mesh(from.mMeshes[k]);
    if (k == 0)
      asset_.nodes[size_t(index)].mesh = shown;
    else
      asset_.nodes.push_back({text_of(from.mName), index, kIdentity4, shown});
  }
}

/// Index of a mesh in the asset; the mesh is converted when it is first shown.
int Conversion::mesh(unsigned index) {
  const auto found = mesh_of_.find(index);
  if (found != mesh_of_.end()) return found->second;
  ELASTOGEN_CHECK_ASSET(index < scene_.mNumMeshes, "there is no mesh ", index);
  const aiMesh& from = *scene_.mMeshes[index];
  Mesh& mesh = asset_.meshes.emplace_back();
  mesh.name = text_of(from.mName);
  add_vertices(from, mesh);
  add_faces(from, mesh);
  add_finding(asset_, "skins", from.HasBones() ? 1 : 0,
              "skinned meshes are taken in their bind pose");
  add_finding(asset_, "morph-targets", from.mNumAnimMeshes,
              "meshes have morph targets; the base shape is used");
  return mesh_of_[index] = int(asset_.meshes.size()) - 1;
}

void Conversion::add_vertices(const aiMesh& from, Mesh& mesh) {
  const bool has_uv = from.HasTextureCoords(0), has_normal = from.HasNormals();
  const bool has_colour = from.HasVertexColors(0);
  for (unsigned i = 0; i < from.mNumVertices; ++i) {
    const aiVector3D& p = from.mVertices[i];
    mesh.position.push_back({p.x, p.y, p.z});
    mesh.position_of.push_back(int32_t(i));
    if (has_uv) {
      const aiVector3D& t = from.mTextureCoords[0][i];
      mesh.uv.push_back({t.x, 1 - t.y});
    }
    if (has_normal) {
      const aiVector3D& n = from.mNormals[i];
      mesh.normal.push_back({n.x, n.y, n.z});
    }
    if (has_colour) {
      const aiColor4D& c = from.mColors[0][i];
      mesh.colour.push_back({c.r, c.g, c.b, c.a});
    }
  }
}

void Conversion::add_faces(const aiMesh& from, Mesh& mesh) {
  TriangleGroup& group = mesh.groups.emplace_back();
  if (from.mMaterialIndex < scene_.mNumMaterials) group.material = int(from.mMaterialIndex);
  std::vector<Vec3> corners;
  int64_t left_out = 0;
  for (unsigned f = 0; f < from.mNumFaces; ++f) {
    const aiFace& face = from.mFaces[f];
    if (face.mNumIndices < 3) ++left_out;
    corners.clear();
    for (unsigned k = 0; k < face.mNumIndices; ++k) {
      ELASTOGEN_CHECK_ASSET(face.mIndices[k] < from.mNumVertices, "mesh \"", mesh.name, "\": face ",
                            f, " has the vertex ", face.mIndices[k], ", there are ",
                            from.mNumVertices);
      corners.push_back(mesh.position[face.mIndices[k]]);
    }
    for (const int k : triangulate(corners)) group.corner.push_back(int32_t(face.mIndices[k]));
  }
  add_finding(asset_, "points-and-lines", left_out, "primitives are points or lines");
}

}  // namespace

Asset read_assimp(const std::string& path, const std::string& format) {
  const std::string bytes = read_file(path);
  Assimp::Importer importer;
  keep_importer(importer, format);
  importer.SetIOHandler(new ClosedSystem);  // owned by the importer
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, false);
  const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), 0, format.c_str());
  if (!scene) throw_reason(importer);
  Asset asset;
  asset.format = format;
  Conversion(*scene, asset).run();
  return asset;
}

}  // namespace elastogen
