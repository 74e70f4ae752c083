// Long work in stages, each loaded from a store by its key, or made and saved.
#pragma once

#include <istream>
#include <optional>
#include <sstream>
#include <streambuf>
#include <string>
#include <string_view>
#include <utility>

#include <cereal/archives/binary.hpp>

#include "relight/blob_store.h"
#include "relight/internal/content_hash.h"
#include "relight/progress.h"

namespace pleinair::internal {

class StoredStages {
 public:
  // Both outlive this.
  StoredStages(BlobStore& store, const Progress& progress) : store_(store), progress_(progress) {}

  // `parts(archive)` reads or writes what `make()` makes.
  template <class Make, class Parts>
  void Run(std::string_view name, const std::string& key, const Make& make, const Parts& parts) {
    const std::optional<Blob> sealed = store_.Load(key);
    if (const std::optional<std::string_view> bytes = Unsealed(key, sealed)) {
      BytesInPlace buffer(*bytes);
      std::istream in(&buffer);
      cereal::BinaryInputArchive archive(in);
      parts(archive);
      return;
    }
    all_loaded_ = false;
    Report(name, 0.0);
    make();
    std::ostringstream out(std::ios::binary);
    cereal::BinaryOutputArchive archive(out);
    parts(archive);
    const std::string bytes = std::move(out).str();
    store_.Save(key, Seal(key, bytes) + bytes);
    Report(name, 1.0);
  }

  bool AllLoaded() const { return all_loaded_; }

 private:
  // Copying a large site's bytes takes longer than reading them. They must outlive this object.
  class BytesInPlace : public std::streambuf {
   public:
    explicit BytesInPlace(std::string_view bytes) {
      // setg takes char*; nothing is written.
      char* const begin = const_cast<char*>(bytes.data());
      setg(begin, begin, begin + bytes.size());
    }
  };

  // Hash of key and bytes, put in front of the bytes, so that a damaged part, or another key's, is
  // detected before anything reads the sizes in it.
  static std::string Seal(std::string_view key, std::string_view bytes) {
    return ContentHash().Add(key).Add(bytes).Hex();
  }

  static std::optional<std::string_view> Unsealed(std::string_view key,
                                                  const std::optional<Blob>& sealed) {
    constexpr std::size_t kSealSize = 32;
    if (!sealed || sealed->Bytes().size() < kSealSize) return std::nullopt;
    const std::string_view whole = sealed->Bytes();
    const std::string_view bytes = whole.substr(kSealSize);
    if (Seal(key, bytes) != whole.substr(0, kSealSize)) return std::nullopt;
    return bytes;
  }

  void Report(std::string_view name, double share) const {
    if (progress_) progress_(name, share);
  }

  BlobStore& store_;
  const Progress& progress_;
  bool all_loaded_ = true;
};

}  // namespace pleinair::internal
