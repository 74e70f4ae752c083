// A frame with everything that is needed to run it again.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/viewer/frame_worker.h"

namespace pleinair {

struct SnapshotChoices {
  std::vector<VirtualObjectEntry> objects;
  std::vector<std::string> settings;  // "name=value".
  EffectSettings effects;
};

// Makes a folder in `out`, named after the frame's time, and returns it. It holds a sequence of
// this frame (site, objects and picture), lighting.jsonl with its light, settings.txt, and
// composite.png and .exr. run.txt has the command line that gives the same composite. Throws
// std::runtime_error, one line; then there is no such folder. The frame has to have succeeded.
std::filesystem::path WriteSnapshot(const ViewedSite& site,
                                    const ViewedFrame& frame,
                                    const SnapshotChoices& choices,
                                    const std::filesystem::path& out);

}  // namespace pleinair
