// Scores a run of a sequence frame by frame, whether it was written or is still in memory.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "datasets/lighting_record.h"
#include "datasets/scoring.h"
#include "datasets/sequence.h"
#include "scene/image.h"

namespace pleinair {

// A frame's composite as `run` writes it, in half precision.
struct ScoredComposite {
  RgbImage radiance;
  std::optional<Gray8Image> change;  // Its mask, 0 where nothing has changed.
};

class RunScorer {
 public:
  // Reads truth/. Keeps a reference to `sequence`.
  // Throws std::runtime_error naming file and place where truth or mesh cannot be read.
  explicit RunScorer(const Sequence& sequence);
  ~RunScorer();
  RunScorer(RunScorer&&) noexcept;

  // Whether the truth has the picture with the object for `frame`.
  bool HasPictureOf(int frame) const;

  // Adds what the run says of record.frame; a frame without truth is passed over. `composite` is
  // called where there is something to compare it with; what it throws is the reason why there is
  // no score. Empty: the run has no composites, and none are missed.
  void Add(const LightingRecord& record, const std::function<ScoredComposite()>& composite);

  // The score of all that was added since the last call. Forgets it: the next run may be added.
  Score Finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pleinair
