// The folder that a run writes to.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "apps/descriptor.h"
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

// A folder of results, held by one process at a time, and free again when that ends, however it
// ends. What is in it stays.
class FolderLock {
 public:
  // Makes the folder where there is none; one without a result is removed again. Throws
  // std::runtime_error naming the folder and who holds it, why it cannot be locked, or which result
  // of an earlier run cannot be replaced: it is no regular file, no folder of pictures, or may not
  // be a run's, as the log is not there that each run makes first.
  explicit FolderLock(std::filesystem::path folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  const std::filesystem::path& Folder() const { return folder_; }
  // Who held it last and did not end as it should ("process 4711 on HOST since TIME"); or empty.
  const std::string& TakenOverFrom() const { return taken_over_from_; }

 private:
  void Remove();

  std::filesystem::path folder_;
  bool is_made_ = false;  // By this one.
  Descriptor file_;
  std::string taken_over_from_;
};

// One run's output: nothing of an earlier run, ended or killed, stays beside the new one's; all
// else does. lighting.jsonl, plan.jsonl and events.jsonl have their names only when they are
// complete. Results of an earlier run stay until Begin or Finish; a run that does not get there
// leaves nothing, but for the log that shows that a killed run's pictures are a run's.
class RunFolder {
 public:
  // Removes what a killed run left unfinished. `lock` outlives it. Throws std::runtime_error where
  // a file cannot be removed or made.
  explicit RunFolder(const FolderLock& lock);
  ~RunFolder();
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;

  // Whether there were an earlier run's results.
  bool HadResults() const { return had_results_; }
  // Whether a killed run had left something: one that was killed while it prepared has not.
  bool HadUnfinished() const { return had_unfinished_; }
  // Removes an earlier run's results, once: before the first frame's files are written.
  void Begin();
  bool HasBegun() const { return has_begun_; }
  // A frame's lines: both or, where that fails, none.
  void AddFrame(const std::string& lighting, const std::string& plan);
  // From any one thread. events.jsonl is there from the first event on.
  void AddEvent(const std::string& line);
  // As Begin where that was not called.
  void Finish();

 private:
  // A line a frame; whole lines also where the disk is full.
  class Log {
   public:
    explicit Log(std::filesystem::path file);
    void Add(const std::string& line) { lines_.Add(line); }
    void RemoveLast() { lines_.RemoveLast(); }
    void Finish();
    void Remove();

   private:
    std::filesystem::path file_;
    std::filesystem::path partial_;
    LineFile lines_;
  };

  std::filesystem::path out_;
  bool had_results_ = false;
  bool had_unfinished_ = false;
  bool has_begun_ = false;
  std::optional<Log> lighting_;
  std::optional<Log> plan_;
  std::optional<Log> events_;
};

}  // namespace pleinair
