// A sequence as JSON.
#pragma once

#include <filesystem>

#include <nlohmann/json.hpp>

#include "datasets/sequence.h"

namespace pleinair {

// An entry of `frames`.
nlohmann::ordered_json JsonOf(const FrameEntry& frame);
// One of `virtual_objects`.
nlohmann::ordered_json JsonOf(const VirtualObjectEntry& object);
// The complete sequence.json.
nlohmann::ordered_json JsonOf(const Sequence& sequence);

// `folder`/sequence.json, as WriteSequence.
void WriteSequenceJson(const nlohmann::ordered_json& json, const std::filesystem::path& folder);

}  // namespace pleinair
