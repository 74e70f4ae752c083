#include "session/moving_things_search.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "datasets/frame_source.h"
#include "pipeline/light_trials.h"
#include "session/loaded_sequence.h"
#include "session/session_choices.h"

namespace pleinair {
namespace {

// `most` of them, the first and the last included.
std::vector<FrameEntry> Spread(const std::vector<FrameEntry>& frames, int most) {
  const auto count = static_cast<std::size_t>(most);
  if (frames.size() <= count) return frames;
  std::vector<FrameEntry> spread;
  for (std::size_t i = 0; i < count; ++i) {
    spread.push_back(frames[i * (frames.size() - 1) / std::max<std::size_t>(count - 1, 1)]);
  }
  return spread;
}

}  // namespace

MovingThingsInSequence FindMovingThings(const SessionOptions& options,
                                        int most_frames,
                                        const MovingThingsOptions& moving,
                                        const Progress& progress) {
  if (most_frames < 3) {
    throw std::invalid_argument(
        fmt::format("most_frames: expected 3 or more, found {}", most_frames));
  }
  const auto loaded = LoadSequence(options, progress);
  Sequence sequence = loaded->sequence;
  sequence.frames = Spread(sequence.frames, most_frames);
  std::vector<std::unique_ptr<LightingSource>> source;
  source.push_back(MakeSourceFor(options, sequence, loaded->scene.aerosol_optical_depth_500nm));
  LightTrials light(loaded->scene, sequence.site, PipelineOptionsFor(options, *loaded).view);
  const auto frames = MakeRecordedFrameSource(sequence, options.frames, options.camera_noise);

  MovingThingsInSequence result;
  MovingThings things(moving);
  const auto leave_out = [&](const std::string& why) {
    if (result.left_out++ == 0) result.why_left_out = why;
  };
  while (auto frame = frames->Next()) {
    if (!*frame) {
      leave_out(frame->error().reason);
      continue;
    }
    const auto trials = light.Process(**frame, source);
    if (!trials) {
      leave_out(trials.error().reason);
    } else if (!trials->front()) {
      leave_out(trials->front().error().reason);
    } else if (!things.Add(**frame, light.View(), trials->front()->estimate.lighting)) {
      leave_out(fmt::format("frame {}: the camera stands elsewhere", (*frame)->index));
    } else if (result.shown.radiance.Empty()) {
      result.shown = std::move(**frame);
    }
  }
  result.found = things.Find();
  if (result.found.frames < 3) {
    throw std::runtime_error(fmt::format(
        "{}: expected three frames or more of one camera pose, whose light can be estimated, found "
        "{}{}",
        options.sequence.string(),
        result.found.frames,
        result.left_out > 0 ? " (" + result.why_left_out + ")" : ""));
  }
  return result;
}

}  // namespace pleinair
