// A value that is kept together with the key it was computed from.
#pragma once

#include <optional>
#include <utility>

namespace pleinair {

// With another key, the value is recomputed; no caller has to invalidate it. Where `make` throws,
// nothing is kept.
template <class Value, class Key>
class Cached {
 public:
  // Whether the value was computed from `key`.
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

  // The last value, for any key (see IsOf); Value() before the first.
  const Value& Kept() const { return value_; }
  Value& Kept() { return value_; }

 private:
  std::optional<Key> key_;
  Value value_{};
};

}  // namespace pleinair
