#include "calib/response.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "calib/json_cursor.h"
#include "scene/srgb.h"

namespace pleinair {
namespace {

void RequireExposure(double exposure) {
  if (!(exposure > 0.0) || !std::isfinite(exposure)) {
    throw std::invalid_argument("exposure " + std::to_string(exposure) +
                                ": expected a positive number");
  }
}

}  // namespace

void ResponseCurve::Channel::FillThresholds() {
  for (std::size_t code = 0; code < threshold_above_code.size(); ++code) {
    threshold_above_code[code] = 0.5f * (linear_of_code[code] + linear_of_code[code + 1]);
  }
  FillGuesses();
}

void ResponseCurve::Channel::FillGuesses() {
  std::size_t code = 0;
  for (std::size_t i = 0; i < guess.size(); ++i) {
    const float lower_end = static_cast<float>(i) / static_cast<float>(kGuesses);
    while (code < threshold_above_code.size() && lower_end >= threshold_above_code[code]) ++code;
    guess[i] = static_cast<std::uint8_t>(code);
  }
}

std::uint8_t ResponseCurve::Channel::Code(float linear) const {
  // Negated so that NaN is caught with the values below 0.
  if (!(linear >= 0.0f)) linear = 0.0f;
  if (linear > 1.0f) linear = 1.0f;
  const auto part = static_cast<std::size_t>(linear * static_cast<float>(kGuesses));
  std::size_t code = guess[std::min(part, guess.size() - 1)];
  while (code < threshold_above_code.size() && linear >= threshold_above_code[code]) ++code;
  return static_cast<std::uint8_t>(code);
}

ResponseCurve ResponseCurve::Srgb() {
  Channel channel;
  for (std::size_t code = 0; code < 256; ++code) {
    const double encoded = static_cast<double>(code);
    channel.linear_of_code[code] = static_cast<float>(LinearFromSrgb(encoded / 255.0));
    // Halfway in the encoded scale, where an sRGB camera rounds.
    if (code < 255) {
      channel.threshold_above_code[code] =
          static_cast<float>(LinearFromSrgb((encoded + 0.5) / 255.0));
    }
  }
  channel.FillGuesses();
  ResponseCurve curve;
  curve.channels_.fill(channel);
  return curve;
}

ResponseCurve ResponseCurve::FromTable(const ResponseTable& linear_of_code_rgb) {
  ResponseCurve curve;
  for (std::size_t c = 0; c < 3; ++c) {
    Channel& channel = curve.channels_[c];
    channel.linear_of_code = linear_of_code_rgb[c];
    for (std::size_t code = 0; code < 256; ++code) {
      const float value = channel.linear_of_code[code];
      const float low = code == 0 ? 0.0f : channel.linear_of_code[code - 1];
      if (value >= low && value <= 1.0f) continue;
      throw std::invalid_argument("response of channel " + std::to_string(c) + " at code " +
                                  std::to_string(code) + ", " + std::to_string(value) +
                                  ": expected a value in [0, 1], not below the one before");
    }
    if (!(channel.linear_of_code[255] > channel.linear_of_code[0])) {
      throw std::invalid_argument("response of channel " + std::to_string(c) +
                                  ": expected values that rise from code 0 to code 255");
    }
    channel.FillThresholds();
  }
  return curve;
}

ResponseCurve ResponseCurve::FromFile(const std::filesystem::path& file) {
  const nlohmann::json document = LoadJson(file);
  const JsonCursor root(document, file.string());
  root.CheckKeys({"format", "version", "linear_of_code_rgb"});
  root.Required("format").OneOf({"pleinair-response"});
  root.Required("version").IntegerIn(1, 1);
  const std::vector<JsonCursor> lists = root.Required("linear_of_code_rgb").List(3, 3);
  ResponseTable table{};
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<JsonCursor> values = lists[c].List(256, 256);
    for (std::size_t code = 0; code < 256; ++code) {
      const float low = code == 0 ? 0.0f : table[c][code - 1];
      table[c][code] = static_cast<float>(values[code].NumberIn(0.0, 1.0));
      if (table[c][code] < low) {
        values[code].Fail("a value not below the one before, " + std::to_string(low));
      }
    }
    if (!(table[c][255] > table[c][0])) lists[c].Fail("values that rise from code 0 to code 255");
  }
  return FromTable(table);
}

std::string ResponseCurve::FileText() const {
  nlohmann::ordered_json json = {{"format", "pleinair-response"}, {"version", 1}};
  nlohmann::ordered_json& lists = json["linear_of_code_rgb"] = nlohmann::ordered_json::array();
  for (const Channel& channel : channels_) lists.push_back(channel.linear_of_code);
  return json.dump() + "\n";
}

glm::u8vec3 ResponseCurve::CodeFromLinear(const glm::vec3& linear) const {
  return {channels_[0].Code(linear.x), channels_[1].Code(linear.y), channels_[2].Code(linear.z)};
}

RgbImage RadianceFromCodes(const Rgb8Image& codes, const ResponseCurve& response, double exposure) {
  RequireExposure(exposure);
  ResponseTable radiance_of_code;
  for (int c = 0; c < 3; ++c) {
    std::ranges::transform(
        response.LinearOfCode(c),
        radiance_of_code.at(static_cast<std::size_t>(c)).begin(),
        [=](float linear) { return static_cast<float>(double{linear} / exposure); });
  }
  RgbImage radiance(codes.width, codes.height);
  for (std::size_t i = 0; i < codes.pixels.size(); ++i) {
    const glm::u8vec3& code = codes.pixels[i];
    radiance.pixels[i] = {
        radiance_of_code[0][code.x], radiance_of_code[1][code.y], radiance_of_code[2][code.z]};
  }
  return radiance;
}

glm::u8vec3 CodeFromRadiance(const glm::vec3& radiance,
                             const ResponseCurve& response,
                             double exposure) {
  return response.CodeFromLinear(glm::vec3(glm::dvec3(radiance) * exposure));
}

Rgb8Image CodesFromRadiance(const RgbImage& radiance,
                            const ResponseCurve& response,
                            double exposure) {
  RequireExposure(exposure);
  Rgb8Image codes(radiance.width, radiance.height);
  for (std::size_t i = 0; i < radiance.pixels.size(); ++i) {
    codes.pixels[i] = CodeFromRadiance(radiance.pixels[i], response, exposure);
  }
  return codes;
}

}  // namespace pleinair
