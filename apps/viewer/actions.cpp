#include "apps/viewer/actions.h"

#include <algorithm>
#include <exception>

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

bool SaveMask(ViewModel& model) {
  return model.mask && Report(
                           "mask", [&] { model.mask->Save(); }, model);
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
  switch (model.tool) {
    case Tool::kObjects:
      return model.editor && Report(
                                 "objects", [&] { model.editor->Save(); }, model);
    case Tool::kMask:
      if (!SaveMask(model)) return false;
      model.Reload();
      return true;
    case Tool::kPose:
      if (!model.pose || !Report(
                             "pose", [&] { model.pose->Save(); }, model))
        return false;
      model.pose.reset();  // The next picks are of the pose that is read again.
      model.Reload();
      return true;
    case Tool::kColour:
      if (!model.colour || !Report(
                               "colours", [&] { model.colour->Save(); }, model))
        return false;
      model.colour.reset();  // The next ones are by the response that is read again.
      model.Reload();
      return true;
    case Tool::kResponse:
      if (!model.response || !Report(
                                 "response", [&] { model.response->Save(); }, model))
        return false;
      model.Reload();
      return true;
  }
  return false;
}

void Undo(ViewModel& model) {
  if (model.tool == Tool::kObjects && model.editor) model.editor->Undo();
  if (model.tool == Tool::kMask && model.mask) model.mask->Undo();
  if (model.tool == Tool::kPose && model.pose) model.pose->TakeBack();
  if (model.tool == Tool::kColour && model.colour) model.colour->Undo();
  if (model.tool == Tool::kResponse && model.response) model.response->Undo();
}

void Redo(ViewModel& model) {
  if (model.tool == Tool::kObjects && model.editor) model.editor->Redo();
  if (model.tool == Tool::kColour && model.colour) model.colour->Redo();
  if (model.tool == Tool::kResponse && model.response) model.response->Redo();
}

bool HasUnsavedWork(const ViewModel& model) {
  return (model.editor && model.editor->HasUnsavedEdits()) ||
         (model.mask && model.mask->HasUnsavedStrokes());
}

void SaveAndQuit(ViewModel& model) {
  const bool is_saved =
      (!model.editor->HasUnsavedEdits() || Report(
                                               "objects", [&] { model.editor->Save(); }, model)) &&
      (!model.mask || !model.mask->HasUnsavedStrokes() || SaveMask(model));
  model.quitting = is_saved ? Quitting::kYes : Quitting::kNo;
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
  if (!model.snapshot_is_wanted || !model.frame || !model.frame->IsComplete()) return false;
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
  if (!model.response || !model.frame) return;
  const bool is_stated = model.typed_exposure > 0.0;
  model.status = model.response->Take(
      *model.frame, is_stated ? std::optional(model.typed_exposure) : std::nullopt);
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
