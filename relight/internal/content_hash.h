// Keys of prepared parts: a hash of all that they depend on.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include <xxhash.h>

#include "scene/image.h"

namespace pleinair::internal {

class ContentHash {
 public:
  ContentHash() : state_(XXH3_createState(), XXH3_freeState) { XXH3_128bits_reset(state_.get()); }

  ContentHash& AddBytes(const void* bytes, std::size_t size) {
    XXH3_128bits_update(state_.get(), &size, sizeof(size));
    XXH3_128bits_update(state_.get(), bytes, size);
    return *this;
  }
  ContentHash& Add(std::string_view text) { return AddBytes(text.data(), text.size()); }
  // For values without padding.
  template <class Value>
  requires std::is_arithmetic_v<Value> ContentHash& Add(Value value) {
    return AddBytes(&value, sizeof(value));
  }
  template <class Value>
  ContentHash& AddAll(const std::vector<Value>& values) {
    static_assert(std::is_trivially_copyable_v<Value>);
    return AddBytes(values.data(), values.size() * sizeof(Value));
  }
  template <class Pixel>
  ContentHash& AddImage(const Image<Pixel>& image) {
    return Add(image.width).Add(image.height).AddAll(image.pixels);
  }
  template <class Vector>
  ContentHash& AddVector(const Vector& v) {
    for (int i = 0; i < Vector::length(); ++i) Add(v[i]);
    return *this;
  }

  // 32 hexadecimal digits.
  std::string Hex() const {
    XXH128_canonical_t canonical;
    XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state_.get()));
    static const char kDigits[] = "0123456789abcdef";
    std::string hex;
    for (const unsigned char byte : canonical.digest) {
      hex += kDigits[byte >> 4];
      hex += kDigits[byte & 15u];
    }
    return hex;
  }

 private:
  std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state_;
};

}  // namespace pleinair::internal
