// What keys, menu and buttons do.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "apps/viewer/view_model.h"

namespace pleinair {

// What was begun with another tool ends.
void TakeTool(Tool tool, ViewModel& model);

// In the window, and in the log of whoever has started it.
void Warn(const std::string& fault, ViewModel& model);

// Save, undo and redo of the tool that is taken. Save writes to the site's file; all but objects is
// then read again. False where it failed, with the reason in the status.
bool Save(ViewModel& model);
void Undo(ViewModel& model);
void Redo(ViewModel& model);

// What would be lost, by the tools' names; empty: nothing.
std::string UnsavedWork(const ViewModel& model);
// Saves the work of all tools. Quits where that succeeds.
void SaveAndQuit(ViewModel& model);

// A frame on or back; round the end where the recording loops.
void Step(int frames, ViewModel& model);
void ToggleRecording(ViewModel& model);
// Once the picture is complete.
void AskForSnapshot(ViewModel& model);
// Not of a picture that an edit has made old, or of a quick one.
bool SnapshotIsDue(const ViewModel& model);
void TakeSnapshot(const std::vector<std::string>& stated_settings,
                  const std::filesystem::path& out,
                  ViewModel& model);

// The other camera's, for colours.
void OpenOtherPicture(const std::filesystem::path& file, ViewModel& model);
// Fits the pose that is shown to the picture's edges.
void RefinePose(ViewModel& model);
// The ColorChecker, of the tool for colours or for the response.
void FindChart(ViewModel& model);
// The shown picture, for the response or the lens.
void TakePicture(ViewModel& model);
// Pictures of a board, for the lens: a file, or a folder of them.
void OpenBoards(const std::filesystem::path& file, ViewModel& model);
// What the lens's thread has found; true where there is something new to show.
bool FollowLens(ViewModel& model);

// A mesh file onto what a pixel of the picture shows.
void AddObject(const std::filesystem::path& mesh, const glm::dvec2& pixel, ViewModel& model);
void Nudge(const glm::dvec2& step_px, ViewModel& model);

}  // namespace pleinair
