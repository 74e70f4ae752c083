// Where prepared parts are kept between runs.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace pleinair {

// Bytes that are only read: in memory, or wherever their owner keeps them.
class Blob {
 public:
  // NOLINTNEXTLINE(google-explicit-constructor): a string is a blob.
  Blob(std::string bytes) : Blob(std::make_shared<const std::string>(std::move(bytes))) {}
  // `bytes` are valid as long as their owner.
  Blob(std::shared_ptr<const void> owner, std::string_view bytes)
      : owner_(std::move(owner)), bytes_(bytes) {}

  std::string_view Bytes() const { return bytes_; }
  friend bool operator==(const Blob& a, std::string_view b) { return a.bytes_ == b; }

 private:
  explicit Blob(const std::shared_ptr<const std::string>& bytes) : Blob(bytes, *bytes) {}

  std::shared_ptr<const void> owner_;
  std::string_view bytes_;
};

// A store of blobs by content key. An implementation may keep nothing.
class BlobStore {
 public:
  virtual ~BlobStore() = default;
  virtual std::optional<Blob> Load(std::string_view key) = 0;
  // Stores completely or not at all; a failure to store is not an error for the caller.
  virtual void Save(std::string_view key, std::string_view bytes) = 0;
};

class KeepsNothing final : public BlobStore {
 public:
  std::optional<Blob> Load(std::string_view) override { return std::nullopt; }
  void Save(std::string_view, std::string_view) override {}
};

}  // namespace pleinair
