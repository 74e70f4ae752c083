// A value that is kept with what it was made from.
#pragma once

#include <optional>
#include <utility>

namespace pleinair {

// With another key, the value is recomputed; no caller has to remember to drop it. Where the
// making throws, nothing is kept.
template <class Value, class Key>
class Cached {
 public:
  // Whether the value was made from `key`.
  bool IsOf(const Key& key) const { return key_ == key; }

  // `make` takes nothing and returns the value.
  template <class Make>
  Value& Get(const Key& key, Make&& make) {
    if (!IsOf(key)) {
      key_.reset();
      value_ = std::forward<Make>(make)();
      key_ = key;
    }
    return value_;
  }

  // What was last made; Value() before that. Of the present key only where IsOf says so.
  const Value& Kept() const { return value_; }
  Value& Kept() { return value_; }

 private:
  std::optional<Key> key_;
  Value value_{};
};

}  // namespace pleinair
