#include "apps/viewer/actions.h"

#include <algorithm>
#include <exception>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/viewer/snapshot.h"

namespace pleinair {
namespace {

// False where `write` failed.
template <typename Write>
bool Report(const char* what, const Write& write, ViewModel& model) {
  try {
    write();
    model.status = fmt::format("{} saved to {}", what, model.site->loaded->sequence.file.string());
    return true;
  } catch (const std::exception& error) {
    Warn(error.what(), model);
    return false;
  }
}

// In the order that they are saved in: colours are factors of the response.
constexpr std::pair<Tool, const char*> kEdited[] = {{Tool::kObjects, "objects"},
                                                    {Tool::kMask, "mask"},
                                                    {Tool::kPose, "camera's pose"},
                                                    {Tool::kLens, "lens"},
                                                    {Tool::kResponse, "response"},
                                                    {Tool::kColour, "colours"}};

bool HasUnsaved(Tool tool, const ViewModel& model) {
  switch (tool) {
    case Tool::kObjects:
      return model.editor && model.editor->HasUnsavedEdits();
    case Tool::kMask:
      return model.mask && model.mask->HasUnsavedStrokes();
    case Tool::kPose:
      return model.pose && model.pose->HasUnsavedPicks();
    case Tool::kColour:
      return model.colour && model.colour->HasUnsavedPicks();
    case Tool::kResponse:
      return model.response && model.response->HasUnsavedPicks();
    case Tool::kLens:
      return model.lens && model.lens->HasUnsavedPicks();
  }
  return false;
}

bool SaveLens(ViewModel& model) {
  if (!model.lens) return false;
  try {
    model.status = model.lens->Save(model.saves_lens_in_doubt);
    return true;
  } catch (const std::exception& error) {
    Warn(error.what(), model);
    return false;
  }
}

bool SaveOf(Tool tool, ViewModel& model) {
  const auto save = [&](auto& edited, const char* what) {
    return edited && Report(
                         what, [&] { edited->Save(); }, model);
  };
  bool is_saved = false;
  switch (tool) {
    case Tool::kObjects:
      return save(model.editor, "objects");
    case Tool::kMask:
      if (model.mask && !model.mask->HasUnsavedStrokes()) {
        model.status = "mask: nothing was painted since it was read or saved";
        return false;
      }
      is_saved = save(model.mask, "mask");
      break;
    case Tool::kPose:
      is_saved = save(model.pose, "pose");
      break;
    case Tool::kColour:
      is_saved = save(model.colour, "colours");
      if (is_saved) model.colour.reset();  // The factors are in the response: not once more.
      break;
    case Tool::kResponse:
      is_saved = save(model.response, "response");
      break;
    case Tool::kLens:
      model.lens_save_is_wanted = false;
      is_saved = SaveLens(model);
      break;
  }
  if (is_saved) model.Reload();
  return is_saved;
}

}  // namespace

void Warn(const std::string& fault, ViewModel& model) {
  model.status = fault;
  spdlog::warn("{}", fault);
}

void TakeTool(Tool tool, ViewModel& model) {
  if (tool == model.tool) return;
  model.hand.LetGo(model);
  model.tool = tool;
}

bool Save(ViewModel& model) {
  if (model.tool == Tool::kLens && model.lens) {
    model.hand.Release(model);  // A corner where it is.
    if (model.lens->IsBusy()) {
      model.lens_save_is_wanted = true;
      model.status = "lens: it will be saved once it is fitted";
      return false;
    }
  }
  return SaveOf(model.tool, model);
}

void Undo(ViewModel& model) {
  if (model.tool == Tool::kObjects && model.editor) model.editor->Undo();
  if (model.tool == Tool::kMask && model.mask) model.mask->Undo();
  if (model.tool == Tool::kPose && model.pose) model.pose->Undo();
  if (model.tool == Tool::kColour && model.colour) model.colour->Undo();
  if (model.tool == Tool::kResponse && model.response) model.response->Undo();
  if (model.tool == Tool::kLens && model.lens) model.lens->Undo();
}

void Redo(ViewModel& model) {
  if (model.tool == Tool::kObjects && model.editor) model.editor->Redo();
  if (model.tool == Tool::kMask && model.mask) model.mask->Redo();
  if (model.tool == Tool::kPose && model.pose) model.pose->Redo();
  if (model.tool == Tool::kColour && model.colour) model.colour->Redo();
  if (model.tool == Tool::kResponse && model.response) model.response->Redo();
  if (model.tool == Tool::kLens && model.lens) model.lens->Redo();
}

std::string UnsavedWork(const ViewModel& model) {
  std::string names;
  for (const auto& [tool, name] : kEdited) {
    if (!HasUnsaved(tool, model)) continue;
    if (!names.empty()) names += ", ";
    names += name;
  }
  return names;
}

void SaveAndQuit(ViewModel& model) {
  model.quitting = Quitting::kYes;
  for (const auto& [tool, name] : kEdited) {
    if (!HasUnsaved(tool, model) || SaveOf(tool, model)) continue;
    model.quitting = Quitting::kNo;
    return;
  }
}

void Step(int frames, ViewModel& model) {
  if (!model.frame || !model.CanSeek()) return;
  const int count = model.FrameCount();
  const int wanted = model.frame->Index() + frames;
  model.request.is_playing = false;
  if (count == 0) {
    model.Seek(std::max(0, wanted));  // Of a video, whose end is not known.
  } else {
    model.Seek(model.request.loops ? (wanted + count) % count : std::clamp(wanted, 0, count - 1));
  }
}

void ToggleRecording(ViewModel& model) {
  if (model.IsLive()) model.request.is_recording = !model.request.is_recording;
}

void AskForSnapshot(ViewModel& model) {
  if (model.Result() == nullptr) return;
  model.snapshot_is_wanted = true;
  model.status = "snapshot: waiting for the complete picture";
}

bool SnapshotIsDue(const ViewModel& model) {
  if (!model.snapshot_is_wanted || !model.frame) return false;
  if (!model.frame->Succeeded() || !model.frame->IsComplete()) return false;
  const ViewRequest& answered = model.frame->request;
  return answered.edits == model.request.edits &&
         answered.settings_changes == model.request.settings_changes &&
         answered.exposure_stops == model.request.exposure_stops;
}

void TakeSnapshot(const std::vector<std::string>& stated_settings,
                  const std::filesystem::path& out,
                  ViewModel& model) {
  model.snapshot_is_wanted = false;
  const ViewRequest& answered = model.frame->request;
  std::vector<std::string> settings = stated_settings;
  settings.insert(settings.end(), answered.settings.begin(), answered.settings.end());
  try {
    model.status = "snapshot: " + WriteSnapshot(*model.site,
                                                *model.frame,
                                                {answered.objects, settings, answered.effects},
                                                out)
                                      .string();
  } catch (const std::exception& error) {
    Warn(error.what(), model);
  }
}

void OpenOtherPicture(const std::filesystem::path& file, ViewModel& model) {
  if (!model.colour) return;
  try {
    model.colour->OpenOther(file);
    model.status = model.colour->Describe();
  } catch (const std::exception& error) {
    Warn(error.what(), model);
  }
}

void RefinePose(ViewModel& model) {
  if (model.tool != Tool::kPose || !model.pose || !model.frame || !model.frame->input) return;
  model.status = model.pose->RefineByEdges(*model.frame->input);
}

void FindChart(ViewModel& model) {
  if (!TakeUpTool(model)) return;
  if (model.tool == Tool::kColour) model.status = model.colour->FindCharts();
  if (model.tool == Tool::kResponse && model.frame->input) {
    model.status = model.response->FindChart(*model.frame->input);
  }
}

void TakePicture(ViewModel& model) {
  if (!model.frame) return;
  if (model.tool == Tool::kLens && model.lens) {
    model.status = model.lens->Take(*model.frame);
    return;
  }
  if (!model.response) return;
  const bool is_stated = model.typed_exposure > 0.0;
  model.status = model.response->Take(
      *model.frame, is_stated ? std::optional(model.typed_exposure) : std::nullopt);
}

void OpenBoards(const std::filesystem::path& file, ViewModel& model) {
  if (!model.lens) return;
  try {
    model.status = model.lens->Open(file);
  } catch (const std::exception& error) {
    Warn(error.what(), model);
  }
}

bool FollowLens(ViewModel& model) {
  if (!model.lens || !model.lens->Poll()) return false;
  if (model.lens->IsBusy()) return true;
  if (model.lens_save_is_wanted) {
    SaveOf(Tool::kLens, model);
  } else if (model.tool == Tool::kLens) {
    model.status = model.lens->Describe();
  }
  return true;
}

void AddObject(const std::filesystem::path& mesh, const glm::dvec2& pixel, ViewModel& model) {
  if (!model.editor || model.ShownCamera() == nullptr) {
    model.status = "objects can be added once there is a picture";
    return;
  }
  try {
    model.status = model.editor->Add(mesh, *model.ShownCamera(), pixel);
  } catch (const std::exception& error) {
    Warn(error.what(), model);
  }
}

void Nudge(const glm::dvec2& step_px, ViewModel& model) {
  const Camera* camera = model.ShownCamera();
  if (camera != nullptr) model.status = model.editor->Nudge(*camera, step_px);
}

}  // namespace pleinair
