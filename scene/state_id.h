// The identity of a state of something that is too large to be compared, such as a view's images:
// what is computed from it is kept with the identity as its key (see cached.h).
#pragma once

#include <atomic>
#include <cstdint>

namespace pleinair {

// Two states are the same where their identities are equal.
class StateId {
 public:
  // Of no state.
  StateId() = default;
  // Unlike all others in this process. Safe from any thread.
  static StateId Next() {
    static std::atomic<std::uint64_t> last{0};
    StateId id;
    id.number_ = ++last;
    return id;
  }

  bool IsSet() const { return number_ != 0; }
  bool operator==(const StateId&) const = default;

 private:
  std::uint64_t number_ = 0;
};

}  // namespace pleinair
