// A sequence that is read and prepared: what sessions of it share while their offline settings are
// the same.
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

struct LoadedSequence {
  Sequence sequence;
  SequenceSite site;
  PreparedScene scene;
  std::optional<MarkerBoard> board;
  std::optional<PoseTrack> poses;
};

// Reads and prepares, or loads what is prepared; finds albedos from the frames where
// AlbedoSourceOf says so. Throws as ReadSequence, LoadSequenceSite and PrepareScene. A cache that
// cannot keep what was prepared is a note of the site's.
std::shared_ptr<const LoadedSequence> LoadSequence(const SessionOptions& options,
                                                   const Progress& progress = {});

// Of `options.sequence` as a site (see ReadSite), for frames of another source from `time` on:
// albedos or a north that are found from frames are not for it. Where the camera moves, its pose is
// roughly where that begins. Throws as LoadSequence.
std::shared_ptr<const LoadedSequence> LoadSite(const SessionOptions& options,
                                               UtcTime time,
                                               const Progress& progress = {});

// The sequence's frames. What markers or poses from outside could not give goes to `notes`, which
// outlives the source.
std::unique_ptr<FrameSource> FramesOf(const SessionOptions& options,
                                      const LoadedSequence& loaded,
                                      std::vector<std::string>& notes);

using PoseNote = std::function<void(const std::string&)>;
// `frames`, of any source, with poses from markers or from outside where `loaded` has them, or from
// `live` where that is not empty; steadied where they do not come from the sequence, or as
// `options` say. A line to `note` for each frame whose pose is an earlier one.
std::unique_ptr<FrameSource> WithPoses(std::unique_ptr<FrameSource> frames,
                                       const SessionOptions& options,
                                       const LoadedSequence& loaded,
                                       PoseNote note,
                                       PoseAtTime live = {});

}  // namespace pleinair
