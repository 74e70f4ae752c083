#include <algorithm>
#include <cctype>
#include <set>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "pipeline/internal/effects/frame_effect.h"

namespace pleinair::effect_list_test {
namespace {

TEST(EffectList, EveryEffectHasANameOfItsOwnAndAHelpText) {
  std::set<std::string_view> names;
  for (const Effect effect : kAllEffects) {
    const EffectDefinition& definition = DefinitionOf(effect);
    EXPECT_TRUE(names.insert(definition.name).second) << definition.name;
    EXPECT_FALSE(definition.name.starts_with("no-")) << definition.name;
    EXPECT_TRUE(std::all_of(definition.name.begin(), definition.name.end(), [](char c) {
      return c == '-' || std::islower(static_cast<unsigned char>(c));
    })) << definition.name;
    EXPECT_GT(definition.help.size(), 10u) << definition.name;
    EXPECT_LT(definition.help.size(), 100u) << definition.name << ": a line";
  }
  EXPECT_FALSE(names.contains("all"));
  EXPECT_FALSE(names.contains("plan"));
}

TEST(EffectList, SharesAndMakersAreStated) {
  for (const Effect effect : kAllEffects) {
    const EffectDefinition& definition = DefinitionOf(effect);
    EXPECT_NE(definition.make, nullptr) << definition.name;
    EXPECT_GT(definition.rms_share, 0.0) << definition.name;
    EXPECT_LT(definition.rms_share, 1.0) << definition.name << " has the default";
    EXPECT_FALSE(definition.brings.Has(effect)) << definition.name;
  }
}

}  // namespace
}  // namespace pleinair::effect_list_test
