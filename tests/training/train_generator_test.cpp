// SPDX-License-Identifier: Apache-2.0
#include "diffusion/train_generator.hpp"

#include "core/error.hpp"
#include "diffusion/generate_weights.hpp"
#include "diffusion/hidden_hash.hpp"
#include "io/safe_file.hpp"
#include "tests/diffusion/dataset.hpp"

#include <gtest/gtest.h>

#include <filesystem>

namespace elastogen {
namespace {

namespace fs = std::filesystem;

/// A folder with a dataset of 20 materials whose layers are small numbers.
class TrainGeneratorTest : public testing::Test {
 protected:
  TrainGeneratorTest()
      : folder_(fs::temp_directory_path() /
                concat("elastogen-train-generator-",
                       testing::UnitTest::GetInstance()->current_test_info()->name())) {
    fs::create_directories(folder_);
    write_dataset("d.h5", 20);
  }
  ~TrainGeneratorTest() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  void write_dataset(const std::string& name, int64_t count, float change = 0) const {
    WeightDataset data = test::some_dataset(count);
    for (int64_t k = 0; k < data.layers.size(); ++k) data.layers.data()[k] *= 0.1f;
    data.hidden[0] += change;
    write_file(path(name), encode_dataset(data));
  }

  TrainGenerator task(const std::string& out) const {
    TrainGenerator task;
    task.dataset = path("d.h5"), task.out = path(out);
    task.components = 8;
    task.steps = 6, task.batch = 16, task.rate = 1e-3;
    return task;
  }

  TrainGenerator paper(const std::string& out) const {
    TrainGenerator result = task(out);
    result.size = "paper", result.layers = "8,4";
    return result;
  }

  TensorFile file(const std::string& name) const {
    return decode_tensors(read_file(path(name)), name);
  }

  const std::string hash = hidden_hash(test::some_hidden());

 private:
  fs::path folder_;
};

TEST_F(TrainGeneratorTest, WritesAGeneratorWithAndWithoutADenoiser) {
  EXPECT_EQ(train_diffusion(task("g"), {}), TrainEnd::kPassing);
  const WeightGenerator generator(file("g"), "g");
  EXPECT_TRUE(generator.has_denoiser());
  EXPECT_EQ(generator.codec().components(), 8);
  EXPECT_EQ(generator.hidden(), hash);
  EXPECT_FALSE(fs::exists(path("g.part")));
  TrainGenerator none = task("h");
  none.steps = 0;
  EXPECT_EQ(train_diffusion(none, {}), TrainEnd::kPassing);
  const WeightGenerator plain(file("h"), "h");
  EXPECT_FALSE(plain.has_denoiser());
  const FitMaterial material = family_material(3, 99);
  EXPECT_EQ(plain.last_layer(material, Start::kRegression),
            generator.last_layer(material, Start::kRegression));
}

TEST_F(TrainGeneratorTest, TakesTheCodecOfAFile) {
  EXPECT_EQ(train_autoencoder(task("c"), {}), TrainEnd::kPassing);
  TrainGenerator from = task("g");
  from.autoencoder = path("c");
  EXPECT_EQ(train_diffusion(from, {}), TrainEnd::kPassing);
  const WeightCodec codec(file("c"));
  EXPECT_EQ(WeightGenerator(file("g"), "g").codec().scale(), codec.scale());
  EXPECT_EQ(file("c").text["held_out.materials"], "2");
}

TEST_F(TrainGeneratorTest, TrainsThePapersSizes) {
  EXPECT_EQ(train_autoencoder(paper("a"), {}), TrainEnd::kPassing);
  EXPECT_EQ(file("a").text["autoencoder.size0"], "17153");
  EXPECT_EQ(file("a").text["autoencoder.size2"], "4");
  EXPECT_TRUE(file("a").text.contains("held_out.error.weights"));
  TrainGenerator from = paper("p");
  from.autoencoder = path("a");
  EXPECT_EQ(train_diffusion(from, {}), TrainEnd::kPassing);
  EXPECT_EQ(file("p").text["held_out.materials"], "2");
  EXPECT_TRUE(file("p").text.contains("held_out.inside.30"));
}

TEST_F(TrainGeneratorTest, GoesOnFromItsCheckpointWithTheSameBits) {
  for (const bool is_paper : {false, true}) {
    const auto train = [&](const TrainGenerator& t, const FitHooks& hooks) {
      return is_paper ? train_autoencoder(t, hooks) : train_diffusion(t, hooks);
    };
    TrainGenerator one = is_paper ? paper("one") : task("one");
    EXPECT_EQ(train(one, {}), TrainEnd::kPassing);
    TrainGenerator two = is_paper ? paper("two") : task("two");
    FitHooks hooks;
    int asked = 0;
    // the codec asks once a material before
    hooks.stopped = [&] { return ++asked > (is_paper ? 3 : 23); };
    EXPECT_EQ(train(two, hooks), TrainEnd::kStopped);
    EXPECT_TRUE(fs::exists(path("two.part")));
    EXPECT_FALSE(fs::exists(path("two")));
    two.resume = true;
    EXPECT_EQ(train(two, {}), TrainEnd::kPassing);
    EXPECT_EQ(read_file(path("two")), read_file(path("one")));
    fs::remove(path("one")), fs::remove(path("two"));
  }
}

TEST_F(TrainGeneratorTest, RejectsWhatItCannotTrain) {
  // an error of this kind, and no output
  const auto throws = [&](const TrainGenerator& t, bool diffusion, ErrorKind kind) {
    try {
      diffusion ? train_diffusion(t, {}) : train_autoencoder(t, {});
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), kind) << error.what();
      EXPECT_FALSE(fs::exists(t.out)) << error.what();
      return true;
    }
    return false;
  };
  // sizes and files
  for (const bool diffusion : {false, true}) {
    TrainGenerator other = task("o");
    other.size = "huge";
    EXPECT_TRUE(throws(other, diffusion, ErrorKind::kUsage));
    other = task("o");
    other.dataset = path("none");
    EXPECT_TRUE(throws(other, diffusion, ErrorKind::kAsset));
  }
  // layers of the paper's autoencoder
  for (const char* layers : {"x", "8,", ",8", "8,-4", "8;4", "0"}) {
    TrainGenerator other = paper("o");
    other.layers = layers;
    EXPECT_TRUE(throws(other, false, ErrorKind::kUsage)) << layers;
  }
  // no autoencoder, too few materials
  TrainGenerator without = paper("o");
  EXPECT_TRUE(throws(without, true, ErrorKind::kUsage));
  write_dataset("few.h5", 9);
  TrainGenerator few = task("o");
  few.dataset = path("few.h5");
  EXPECT_TRUE(throws(few, false, ErrorKind::kUsage));
}

TEST_F(TrainGeneratorTest, RefusesAutoencodersThatDoNotFit) {
  ASSERT_EQ(train_autoencoder(task("c"), {}), TrainEnd::kPassing);
  TrainGenerator odd = paper("odd");
  odd.layers = "8,5";
  ASSERT_EQ(train_autoencoder(odd, {}), TrainEnd::kPassing);
  write_dataset("other.h5", 20, 1);
  const auto message = [&](TrainGenerator t, const char* autoencoder) -> std::string {
    t.autoencoder = path(autoencoder);
    try {
      train_diffusion(t, {});
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message(paper("o"), "c").find("not an autoencoder of size paper"), std::string::npos);
  EXPECT_NE(message(task("o"), "odd").find("not an autoencoder of size compact"),
            std::string::npos);
  EXPECT_NE(message(paper("o"), "odd").find("no square image"), std::string::npos);
  TrainGenerator other = task("o");
  other.dataset = path("other.h5");
  EXPECT_NE(message(other, "c").find("other hidden layers"), std::string::npos);
}

}  // namespace
}  // namespace elastogen
