// SPDX-License-Identifier: Apache-2.0
// Which files a run may write: none may take the place of another one, or of its input.
#include "cli/typed.hpp"
#include "core/error.hpp"
#include "io/frame_files.hpp"
#include "io/safe_file.hpp"

#include <algorithm>
#include <filesystem>
#include <map>

namespace elastogen {
namespace {

/// The path of a file with its folder resolved (no links, no dots); "" for "".
std::string place_of(const std::string& name) {
  if (name.empty()) return name;
  std::error_code error;
  const std::filesystem::path path = std::filesystem::absolute(name, error).lexically_normal();
  const auto folder = std::filesystem::weakly_canonical(path.parent_path(), error);
  return ((error ? path.parent_path() : folder) / path.filename()).string();
}

/// Names that are in use.
class TakenNames {
 public:
  void take(const std::string& name) {
    if (name.empty()) return;
    const std::string place = place_of(name);
    ELASTOGEN_CHECK(std::find(taken_.begin(), taken_.end(), place) == taken_.end(), name,
                    ": two files of one name: the input and each output need their own");
    taken_.push_back(place);
  }

  /// @throws Error (usage) if a frame after the first has a name that is in use.
  void check_frames(const std::string& output, int64_t frames) const {
    const std::string place = place_of(output), first = frame_file(place, 0);
    for (const std::string& name : taken_)
      ELASTOGEN_CHECK(name == first || !is_frame_of(place, frames, name), name, ": a frame of ",
                      output, " would take its place; give ", output, " another name");
  }

 private:
  std::vector<std::string> taken_;
};

/// Files of scenes that run at one time, each with its scene.
class SharedNames {
 public:
  void take(const NamedScene& scene) {
    const AnimateOptions& o = scene.options;
    read(scene, o.input);
    read(scene, scene.file);
    for (const std::string* name : {&o.log, &o.state, &o.report}) write(scene, *name);
    for (const std::string& name : o.outputs) {
      const std::string first = frame_file(name, 0);
      if (!first.empty()) {
        write(scene, first);
        if (ending_of(name) == "png")
          pictures_.push_back({&scene, name});
        else
          numbered_.insert({place_of(first), {&scene, name}});
      }
      if (has_own_file(name)) write(scene, name);
    }
  }

  /// Call after the last scene. Checks frames against single files.
  void check_frames() const {
    for (const auto& [place, file] : files_) {
      const std::filesystem::path path(place);
      const std::string stem = path.stem().string(), base = stem.substr(0, stem.rfind('_'));
      const std::string ending = path.extension().string();
      for (const auto& [scene, name] : pictures_)
        if (ending == ".png") check_frame(*scene, name, file, place);
      const auto found =
          numbered_.find(frame_path((path.parent_path() / (base + ending)).string(), 0, ending));
      if (found == numbered_.end()) continue;
      check_frame(*found->second.scene, found->second.name, file, place);
    }
  }

 private:
  struct File {
    const NamedScene* scene;
    bool written;
  };
  struct Numbered {
    const NamedScene* scene;
    std::string name;
  };

  [[noreturn]] static void refuse(const NamedScene& a, const NamedScene& b,
                                  const std::string& name) {
    throw Error(concat(name, ": ", a.file, " and ", b.file,
                       " cannot share a file that one of them writes: give each its own outputs"));
  }

  static void check_frame(const NamedScene& scene, const std::string& name, const File& file,
                          const std::string& place) {
    if (&scene != file.scene && is_frame_of(place_of(name), scene.options.frames, place))
      refuse(scene, *file.scene, place);
  }

  void read(const NamedScene& scene, const std::string& name) { use(scene, name, false); }
  void write(const NamedScene& scene, const std::string& name) { use(scene, name, true); }
  void use(const NamedScene& scene, const std::string& name, bool writes) {
    if (name.empty()) return;
    File& file = files_.try_emplace(place_of(name), File{&scene, writes}).first->second;
    if (file.scene != &scene && (writes || file.written)) refuse(*file.scene, scene, name);
    file.written |= writes;
  }

  std::map<std::string, File> files_;         // by resolved path
  std::map<std::string, Numbered> numbered_;  // by the resolved path of their first frame
  std::vector<Numbered> pictures_;            // numbers may stand anywhere in their names
};

}  // namespace

void check_outputs(const AnimateOptions& o, const std::string& scene_file) {
  check_pictures(o.outputs, o.picture);
  TakenNames names;
  const auto is_input = [&](const std::string& name) {
    return place_of(name) == place_of(o.input);
  };
  names.take(o.input);
  for (const std::string* name : {&scene_file, &o.log, &o.state, &o.report}) names.take(*name);
  bool replaced = false;
  for (const std::string& name : o.outputs) {
    names.take(frame_file(name, 0));
    if (!has_own_file(name)) continue;
    if (!replaced && is_input(name))
      replaced = true;
    else
      names.take(name);
  }
  for (const std::string& name : o.outputs) names.check_frames(name, o.frames);
}

void check_outputs(const std::vector<NamedScene>& scenes) {
  SharedNames names;
  for (const NamedScene& scene : scenes) names.take(scene);
  names.check_frames();
}

}  // namespace elastogen
