// A sequence that is read and prepared. Sessions with the same offline settings share it.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calib/marker_board.h"
#include "calib/pose_track.h"
#include "datasets/frame_source.h"
#include "datasets/posed_frame_source.h"
#include "datasets/sequence.h"
#include "relight/prepared_scene.h"
#include "relight/progress.h"
#include "scene/utc_time.h"
#include "session/sequence_site.h"
#include "session/session_options.h"

namespace pleinair {

// A sequence, its site and its prepared scene.
struct LoadedSequence {
  Sequence sequence;
  SequenceSite site;
  PreparedScene scene;
  std::optional<MarkerBoard> board;
  std::optional<PoseTrack> poses;
};

// Reads and prepares a sequence, or loads the prepared parts from the cache; finds albedos from the
// frames where AlbedoSourceOf says so. A cache that fails to store is a note of the site. `poses`:
// those of options.poses, where they were read before: a pipe gives them once. Throws as
// ReadSequence, LoadSequenceSite and PrepareScene.
std::shared_ptr<const LoadedSequence> LoadSequence(const SessionOptions& options,
                                                   const Progress& progress = {},
                                                   std::optional<PoseTrack> poses = {});

// Loads `options.sequence` as a site (see ReadSite), for frames of another source from `time` on.
// Albedos and north are not found from frames. For a camera that moves, its pose is roughly that of
// the beginning. Throws as LoadSequence.
std::shared_ptr<const LoadedSequence> LoadSite(const SessionOptions& options,
                                               UtcTime time,
                                               const Progress& progress = {},
                                               std::optional<PoseTrack> poses = {});

// The sequence's frames. Missing poses, from markers or from outside, are reported in `notes`,
// which outlives the source.
std::unique_ptr<FrameSource> FramesOf(const SessionOptions& options,
                                      const LoadedSequence& loaded,
                                      std::vector<std::string>& notes);

using PoseNote = std::function<void(const std::string&)>;
// Returns `frames`, of any source, with poses from markers or from outside where `loaded` has them,
// or from `live` where that is not empty. They are filtered where they do not come from the
// sequence, or as `options` say. `note` gets a line for each frame whose pose is an earlier one.
std::unique_ptr<FrameSource> WithPoses(std::unique_ptr<FrameSource> frames,
                                       const SessionOptions& options,
                                       const LoadedSequence& loaded,
                                       const PoseNote& note,
                                       PoseAtTime live = {});

}  // namespace pleinair
