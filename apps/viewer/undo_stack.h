// States that edits can go back to, and on to again.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace pleinair {

template <typename State>
class UndoStack {
 public:
  // Before an edit: the state as it is.
  void Remember(const State& now) {
    undone_to_.push_back(now);
    if (undone_to_.size() > kMost) undone_to_.erase(undone_to_.begin());
    redone_to_.clear();
  }
  // Takes the last Remember back, without a redo.
  void Drop(State& now) {
    now = std::move(undone_to_.back());
    undone_to_.pop_back();
  }
  // Each false where there is no such state; `now` then stays.
  bool Undo(State& now) { return Go(undone_to_, redone_to_, now); }
  bool Redo(State& now) { return Go(redone_to_, undone_to_, now); }

 private:
  static constexpr std::size_t kMost = 50;

  static bool Go(std::vector<State>& to, std::vector<State>& back, State& now) {
    if (to.empty()) return false;
    back.push_back(std::move(now));
    now = std::move(to.back());
    to.pop_back();
    return true;
  }

  std::vector<State> undone_to_;
  std::vector<State> redone_to_;
};

}  // namespace pleinair
