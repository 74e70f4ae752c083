// A recorded sequence's scene, prepared, and one of its frames.
#pragma once

#include <filesystem>
#include <memory>

#include "datasets/frame_source.h"
#include "datasets/sequence.h"
#include "relight/prepared_scene.h"
#include "scene/frame.h"
#include "session/file_blob_store.h"
#include "session/sequence_site.h"

namespace pleinair {

struct RecordedPlace {
  Sequence sequence;
  SequenceSite site;
  PreparedScene scene;
  std::unique_ptr<FrameSource> later_frames;  // Those after `frame`.
  Frame frame;

  RecordedPlace(const std::filesystem::path& folder, int frame_index)
      : sequence(ReadSequence(folder)), site(LoadSequenceSite(sequence)) {
    FileBlobStore store;
    scene = PrepareScene(site.model, PrepareOptionsFor(site), store, [](auto, auto) {});
    later_frames = MakeRecordedFrameSource(sequence, FrameKind::kLinear);
    for (int i = 0; i <= frame_index; ++i) frame = later_frames->Next()->value();
  }
};

}  // namespace pleinair
