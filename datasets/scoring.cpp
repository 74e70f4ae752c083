#include "datasets/scoring.h"

#include <cstdio>
#include <map>
#include <stdexcept>

#include "datasets/run_scorer.h"
#include "scene/image_io.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

namespace fs = std::filesystem;

fs::path NumberedFile(const fs::path& folder, int frame, const char* extension) {
  char name[32];
  std::snprintf(name, sizeof(name), "%06d.%s", frame, extension);
  return folder / name;
}

// Reads a frame's files in `out`. Throws std::exception with what is missing.
ScoredComposite ReadComposite(const fs::path& out, int frame) {
  const fs::path file = NumberedFile(out / "composite", frame, "exr");
  if (!fs::exists(file)) throw std::runtime_error(file.string() + " is not there");
  ScoredComposite composite{ReadRadianceImage(file), std::nullopt};
  const fs::path mask = NumberedFile(out / "mask", frame, "png");
  if (fs::exists(mask)) composite.change = ReadMaskImage(mask);
  return composite;
}

std::map<int, LightingRecord> RecordsByFrame(const fs::path& file, const Sequence& sequence) {
  const std::size_t frame_count = sequence.frames.size();
  std::map<int, LightingRecord> records;
  for (LightingRecord& record : ReadLightingRecords(file)) {
    if (static_cast<std::size_t>(record.frame) >= frame_count) {
      throw std::runtime_error(file.string() + ": expected frames of the sequence (0 to " +
                               std::to_string(frame_count - 1) + "), found frame " +
                               std::to_string(record.frame));
    }
    const UtcTime time = sequence.frames[static_cast<std::size_t>(record.frame)].time;
    if (const std::string fault = FaultOfTime(record.time, time); !fault.empty()) {
      throw std::runtime_error(file.string() + ": frame " + std::to_string(record.frame) + ": " +
                               fault);
    }
    records[record.frame] = std::move(record);
  }
  return records;
}

}  // namespace

Score ScoreRun(const fs::path& sequence_folder, const fs::path& out) {
  const Sequence sequence = ReadSequence(sequence_folder);
  RunScorer scorer(sequence);
  for (const auto& [frame, record] : RecordsByFrame(out / "lighting.jsonl", sequence)) {
    scorer.Add(record, [&out, index = frame] { return ReadComposite(out, index); });
  }
  return scorer.Finish();
}

}  // namespace pleinair
