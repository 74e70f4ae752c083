// The cache of prepared parts on disc, shared by all runs of one user.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "relight/prepared_scene.h"

namespace pleinair {

// $XDG_CACHE_HOME/pleinair; ~/.cache/pleinair where that is unset or relative (as the XDG base
// directory specification asks).
// Throws  std::runtime_error when there is neither that variable nor a home folder.
std::filesystem::path DefaultCacheFolder();

constexpr std::uint64_t kDefaultCacheLimitBytes = 2ULL << 30;

// One file for each blob, `<key>.blob`; other files in the folder are never touched. Processes may
// share a folder: a blob appears when complete, by a rename, and its checksum and key are checked
// when it is read. When the blobs exceed the limit, the least recently used ones are removed first.
//
// Keys     1 to 128 letters, digits, '-' and '_' (hex digests, as a rule). Others throw
//          std::invalid_argument: they could lead out of the folder.
// Threads  one object is used by one thread at a time; several objects may share a folder.
class FileBlobStore final : public BlobStore {
 public:
  // An empty `folder` means DefaultCacheFolder(). The first Save makes the folder. `limit_bytes` is
  // for all blobs together, headers included.
  explicit FileBlobStore(std::filesystem::path folder = {},
                         std::uint64_t limit_bytes = kDefaultCacheLimitBytes);

  // Returns nothing where there is no such blob, or only a damaged one, which is removed.
  std::optional<Blob> Load(std::string_view key) override;

  // Stores the blob. Where the disc fails, or the blob alone exceeds the limit, nothing is stored,
  // and SaveFailure() has the reason.
  void Save(std::string_view key, std::string_view bytes) override;

  const std::filesystem::path& Folder() const { return folder_; }
  // Why the last Save stored nothing: one line; empty when it succeeded.
  const std::string& SaveFailure() const { return save_failure_; }

 private:
  std::filesystem::path PathOf(std::string_view key) const;
  void RemoveLeastRecentlyUsed(const std::filesystem::path& keep) const;

  std::filesystem::path folder_;
  std::uint64_t limit_bytes_;
  std::string save_failure_;
};

}  // namespace pleinair
