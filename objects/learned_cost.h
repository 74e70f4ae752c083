// The cost of a kind of work on this machine, learned from measured times.
#pragma once

namespace pleinair {

// A running mean of milliseconds a unit of work; until it has been done once, a stated guess.
class LearnedCost {
 public:
  explicit LearnedCost(double first_guess_ms) : guess_ms_(first_guess_ms), ms_(first_guess_ms) {}

  double Ms() const { return ms_; }
  // The same on every machine and in every run: for choices that must not depend on the clock.
  double NominalMs() const { return guess_ms_; }

  void Learn(double ms) {
    // The mean follows a change within a second of frames; one time that a busy machine delayed has
    // little weight.
    constexpr double kShareOfLast = 0.2;
    ms_ = has_learned_ ? ms_ + kShareOfLast * (ms - ms_) : ms;
    has_learned_ = true;
  }

 private:
  double guess_ms_;
  double ms_;
  bool has_learned_ = false;
};

}  // namespace pleinair
