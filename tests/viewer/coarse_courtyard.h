// Copies of the bundled courtyard, prepared coarsely and once for a program's tests.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "apps/viewer/frame_worker.h"
#include "apps/viewer/view_command.h"
#include "session/loaded_sequence.h"
#include "session/settings.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair {

inline constexpr const char* kCoarseSettings[] = {
    "prepare.patch_size_m=4",
    "prepare.rays=16",
    "light.samples=200",
    "pipeline.view.receiver_block_px=16",
    "pipeline.object_light.gather.rays_per_receiver=32",
    "pipeline.influence.rays_per_receiver=16"};

// A copy that a test may change, without what scoring alone reads.
class CourtyardCopy {
 public:
  CourtyardCopy() {
    namespace fs = std::filesystem;
    const fs::path bundled = fs::path(PLEINAIR_SOURCE_DIR) / "datasets/samples/courtyard";
    for (const fs::directory_entry& entry : fs::directory_iterator(bundled)) {
      if (entry.path().filename() == "truth") continue;
      fs::copy(
          entry.path(), folder_ / entry.path().filename().string(), fs::copy_options::recursive);
    }
  }
  const std::filesystem::path& Path() const { return folder_.Path(); }
  std::filesystem::path operator/(std::string_view name) const { return folder_ / name; }

 private:
  TemporaryFolder folder_;
};

// Of all tests of the program.
inline std::filesystem::path SharedCache() {
  static const TemporaryFolder cache;
  return cache.Path();
}

inline ViewCommandOptions CoarseOptions(const std::filesystem::path& sequence) {
  ViewCommandOptions options;
  for (const char* setting : kCoarseSettings) {
    ApplySetting(setting, options);
    options.stated_settings.emplace_back(setting);
  }
  options.sequence = sequence;
  options.cache = SharedCache();
  options.restores_state = false;
  return options;
}

inline std::shared_ptr<const ViewedSite> ViewedSiteOf(const std::filesystem::path& sequence) {
  auto loaded = LoadSequence(CoarseOptions(sequence));
  RayCaster caster(loaded->site.model.mesh);
  const auto frames = static_cast<int>(loaded->sequence.frames.size());
  return std::make_shared<const ViewedSite>(
      ViewedSite{std::move(loaded), std::move(caster), frames, false, true, false, ""});
}

}  // namespace pleinair
