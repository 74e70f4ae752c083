// Sources of frames: recordings and cameras.
#pragma once

#include <memory>
#include <optional>

#include <tl/expected.hpp>

#include "calib/camera_noise.h"
#include "calib/response.h"
#include "datasets/sequence.h"
#include "scene/frame.h"

namespace pleinair {

// Returns frames in order. A bad one is an error in its place, and the next call continues.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  // None at the end.
  virtual std::optional<tl::expected<Frame, FrameError>> Next() = 0;
  // Frames that Next() will give in all; none where that is not known (a camera).
  virtual std::optional<int> Count() const = 0;
  // Next continues with frame `index`, 0 to Count() - 1. False where frames come only in order.
  virtual bool Seek(int /*index*/) { return false; }
};

// The response of the sequence's 8-bit camera. Throws std::runtime_error where its file cannot be
// read, or lies outside the sequence's folder.
ResponseCurve ResponseOf(const Sequence& sequence);

// Linear pictures or 8-bit ones, where a frame has both.
enum class FrameKind { kLinear, kLdr };

// Whether a frame is played from its linear picture.
bool IsPlayedLinear(const FrameEntry& entry, FrameKind preferred);

// Plays a recorded sequence. `preferred` decides where a frame has both kinds; a frame with one
// kind plays that one. The sequence is copied.
//
// Linear frames are never clipped, and absolute. 8-bit ones give `exposure`-divided light: relative
// where the exposure is from the camera's metadata, and light in [0, 1], relative per frame, where
// it is unknown. `noise` is that of the 8-bit frames' camera. Fish-eye pictures are EXR or HDR. A
// file that is missing, truncated, empty, no file, of another size than its camera's, or outside
// the sequence's folder is an error of that frame only. So is a linear frame or fish-eye picture
// without a finite pixel. Throws std::runtime_error where the sequence's response, fish-eye
// calibration or first frame's mask cannot be read; std::invalid_argument for impossible noise.
std::unique_ptr<FrameSource> MakeRecordedFrameSource(const Sequence& sequence,
                                                     FrameKind preferred,
                                                     const CameraNoise& noise = {});

}  // namespace pleinair
