// SPDX-License-Identifier: Apache-2.0
#include "network/potential/potential_terms.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/viscous.hpp"

namespace elastogen {
namespace {

/// S of PotentialTerms::noise(), the part of each material times a factor(material).
template <class Factor>
double stiffness_of(const Scene& scene, const Factor& factor) {
  const VoxelGrid& grid = scene.grid;
  return ordered_sum(grid.voxel_count(), [&](int64_t begin, int64_t end) {
    double sum = 0;
    for (int64_t v = begin; v < end; ++v) {
      const Material& m = scene.materials[size_t(scene.material(v))];
      sum += grid.fill(v) * grid.h * grid.h * grid.h * (2 * m.mu() + m.lambda()) * factor(m);
    }
    return sum;
  });
}

}  // namespace

PotentialTerms::PotentialTerms(const Scene& scene, LearnedLaws learned, const StepScheme& scheme)
    : scene_(scene),
      learned_(std::move(learned)),
      contact_(scene),
      scheme_(scheme),
      stiffness_(stiffness_of(scene, [](const Material&) { return 1.0; })),
      viscous_time_(stiffness_of(scene, viscous_time) / stiffness_) {
  learned_.resize(scene.materials.size());
  for (size_t m = 0; m < learned_.size(); ++m) {
    const Material& material = scene.materials[m];
    const LearnedLaw* net = learned_[m].get();
    ELASTOGEN_CHECK(!net || (net->law() == material.law && net->poisson() == material.poisson),
                    "the net of material '", material.name, "' was fitted to another law or ",
                    "Poisson ratio");
  }
}

}  // namespace elastogen
