// The folder that a run writes to.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "datasets/recording/line_file.h"

namespace pleinair {

// Throws std::invalid_argument where a folder of results, or one in it that a run clears, is an
// input's folder, holds it or lies in it: inputs are only read.
void RequireApart(const std::filesystem::path& out, const std::filesystem::path& input);

// Throws std::invalid_argument where `file`, which a run reads, is one that it removes from `out`
// first; `option` names it.
void RequireKept(const std::filesystem::path& file,
                 const std::filesystem::path& out,
                 const std::string& option);

// Held by one process at a time, and free again when that ends, however it ends.
class FolderLock {
 public:
  // Throws std::runtime_error naming the folder and who holds it, or why it cannot be locked.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  // Who held it last and did not end as it should ("process 4711 on HOST since TIME"); or empty.
  const std::string& TakenOverFrom() const { return taken_over_from_; }

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
  std::string taken_over_from_;
};

// One run's output: nothing of an earlier run, ended or killed, stays beside the new one's; all
// else does. lighting.jsonl, plan.jsonl and events.jsonl have their names only when they are
// complete. The folder is locked while this lives.
class RunFolder {
 public:
  // Throws as FolderLock, and where what is to be replaced is no regular file.
  explicit RunFolder(std::filesystem::path out);

  const std::string& TakenOverFrom() const { return lock_->TakenOverFrom(); }
  // A frame's lines: both or, where that fails, none.
  void AddFrame(const std::string& lighting, const std::string& plan);
  // From any one thread. events.jsonl is there from the first event on.
  void AddEvent(const std::string& line);
  void Finish();

 private:
  // A line a frame; whole lines also where the disk is full.
  class Log {
   public:
    explicit Log(std::filesystem::path file);
    void Add(const std::string& line) { lines_.Add(line); }
    void RemoveLast() { lines_.RemoveLast(); }
    void Finish();

   private:
    std::filesystem::path file_;
    std::filesystem::path partial_;
    LineFile lines_;
  };

  std::filesystem::path out_;
  std::unique_ptr<FolderLock> lock_;
  std::optional<Log> lighting_;
  std::optional<Log> plan_;
  std::optional<Log> events_;
};

}  // namespace pleinair
