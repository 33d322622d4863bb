// SPDX-License-Identifier: Apache-2.0
#include "voxelize/vdb_io.hpp"

#include "core/error.hpp"
#include "io/safe_file.hpp"

#include <openvdb/openvdb.h>

namespace elastogen {

void write_vdb(const std::string& path, const VoxelGrid& voxels) {
  openvdb::initialize();
  const auto grid = openvdb::FloatGrid::create();
  grid->setName("fill");
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  const auto transform = openvdb::math::Transform::createLinearTransform(voxels.h);
  const double half = voxels.h / 2;
  transform->postTranslate(
      {voxels.origin[0] + half, voxels.origin[1] + half, voxels.origin[2] + half});
  grid->setTransform(transform);
  auto accessor = grid->getAccessor();
  for (int64_t v = 0; v < voxels.voxel_count(); ++v) {
    const int32_t* c = voxels.voxel_coord.row(v);
    accessor.setValue({c[0], c[1], c[2]}, float(voxels.fill(v)));
  }
  SafeFile safe(path);
  try {
    openvdb::io::File file(safe.temporary());
    file.write(openvdb::GridCPtrVec{grid});
    file.close();
  } catch (const openvdb::Exception& error) {
    throw Error(concat(path, ": cannot be written: ", error.what()), ErrorKind::kResources);
  }
  safe.commit();
}

}  // namespace elastogen
