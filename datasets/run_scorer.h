// Scores a run of a sequence frame by frame, from files or from memory.
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

// Collects frames of a run, then returns their score. One thread at a time.
class RunScorer {
 public:
  // Reads truth/. Keeps a reference to `sequence`.
  // Throws std::runtime_error naming file and place where truth or mesh cannot be read.
  explicit RunScorer(const Sequence& sequence);
  ~RunScorer();
  RunScorer(RunScorer&&) noexcept;

  // Whether the truth has the picture with the object for `frame`.
  bool HasPictureOf(int frame) const;

  // Adds the run's result for record.frame; a frame without truth is ignored. `composite` is called
  // where the truth has a picture; an exception is the reason why there is no score. Empty: the run
  // has no composites.
  void Add(const LightingRecord& record, const std::function<ScoredComposite()>& composite);

  // Returns the score of everything added since the last call, and starts again for the next run.
  Score Finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pleinair
