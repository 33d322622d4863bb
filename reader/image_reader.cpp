// SPDX-License-Identifier: Apache-2.0
#include "reader/image_reader.hpp"

#include "core/error.hpp"
#include "io/glb_document.hpp"

#include <jpeglib.h>
#include <png.h>
#include <webp/decode.h>

#include <algorithm>
#include <csetjmp>
#include <cstdio>  // for jpeglib.h

namespace elastogen {
namespace {

Image sized(uint64_t width, uint64_t height) {
  const auto most = uint64_t(kMaxImageEdge);
  ELASTOGEN_CHECK_ASSET(width > 0 && height > 0 && width <= most && height <= most &&
                            width * height <= uint64_t(kMaxImagePixels),
                        "an image of ", width, " x ", height, " pixels is out of range");
  Image image{int(width), int(height), {}};
  image.rgba.resize(4 * width * height);
  return image;
}

Image read_png(const std::string& bytes) {
  png_image png = {};
  png.version = PNG_IMAGE_VERSION;
  Image image;
  try {
    ELASTOGEN_CHECK_ASSET(png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()),
                          "PNG: ", png.message);
    png.format = PNG_FORMAT_RGBA;
    image = sized(png.width, png.height);
    ELASTOGEN_CHECK_ASSET(png_image_finish_read(&png, nullptr, image.rgba.data(), 0, nullptr),
                          "PNG: ", png.message);
  } catch (...) {
    png_image_free(&png);
    throw;
  }
  return image;
}

/// libjpeg, whose errors jump back here.
struct Jpeg {
  Jpeg() {
    info.err = jpeg_std_error(&errors);
    errors.error_exit = [](j_common_ptr common) {
      auto* self = static_cast<Jpeg*>(common->client_data);
      common->err->format_message(common, self->message);
      std::longjmp(self->out, 1);
    };
    errors.output_message = [](j_common_ptr) {};
    info.client_data = this;
  }
  ~Jpeg() { jpeg_destroy_decompress(&info); }
  Jpeg(const Jpeg&) = delete;
  Jpeg& operator=(const Jpeg&) = delete;

  /// @return false after an error. The jump skips destructors, so no object that has one may live
  ///         here.
  bool begin(const std::string& bytes) {
    if (setjmp(out)) return false;
    jpeg_create_decompress(&info);
    jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
    jpeg_read_header(&info, TRUE);
    info.out_color_space = JCS_EXT_RGBA;
    return true;
  }
  bool read(uint8_t* rgba) {
    if (setjmp(out)) return false;
    jpeg_start_decompress(&info);
    while (info.output_scanline < info.output_height) {
      JSAMPROW row = rgba + 4 * size_t(info.output_scanline) * info.output_width;
      jpeg_read_scanlines(&info, &row, 1);
    }
    jpeg_finish_decompress(&info);
    return true;
  }

  jpeg_decompress_struct info = {};
  jpeg_error_mgr errors = {};
  std::jmp_buf out;
  char message[JMSG_LENGTH_MAX] = {};
};

Image read_jpeg(const std::string& bytes) {
  Jpeg jpeg;
  ELASTOGEN_CHECK_ASSET(jpeg.begin(bytes), "JPEG: ", jpeg.message);
  Image image = sized(jpeg.info.image_width, jpeg.info.image_height);
  ELASTOGEN_CHECK_ASSET(jpeg.read(image.rgba.data()), "JPEG: ", jpeg.message);
  return image;
}

Image read_webp(const std::string& bytes) {
  const auto* data = reinterpret_cast<const uint8_t*>(bytes.data());
  int width = 0, height = 0;
  ELASTOGEN_CHECK_ASSET(WebPGetInfo(data, bytes.size(), &width, &height),
                        "WebP: its header is damaged");
  Image image = sized(uint64_t(width), uint64_t(height));
  ELASTOGEN_CHECK_ASSET(
      WebPDecodeRGBAInto(data, bytes.size(), image.rgba.data(), image.rgba.size(), 4 * width),
      "WebP: it is damaged");
  return image;
}

/// The mean of each 2 x 2 pixels; colours are weighted by alpha.
Image halved(const Image& from) {
  Image half = sized(uint64_t(std::max(1, from.width / 2)), uint64_t(std::max(1, from.height / 2)));
  uint8_t* to = half.rgba.data();
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < half.width; ++x, to += 4) {
      unsigned sum[3] = {}, plain[3] = {}, alpha = 0;
      for (int k = 0; k < 4; ++k) {
        const int column = std::min(2 * x + k % 2, from.width - 1);
        const int row = std::min(2 * y + k / 2, from.height - 1);
        const uint8_t* p =
            from.rgba.data() + 4 * (size_t(row) * size_t(from.width) + size_t(column));
        for (int c = 0; c < 3; ++c) sum[c] += unsigned(p[3]) * p[c], plain[c] += p[c];
        alpha += p[3];
      }
      for (int c = 0; c < 3; ++c)
        to[c] = uint8_t(alpha > 0 ? (sum[c] + alpha / 2) / alpha : (plain[c] + 2) / 4);
      to[3] = uint8_t((alpha + 2) / 4);
    }
  return half;
}

}  // namespace

Image read_image(const std::string& bytes, int max_edge) {
  const std::string type = image_type(Bytes(bytes.begin(), bytes.end()));
  ELASTOGEN_CHECK_ASSET(type == "image/png" || type == "image/jpeg" || type == "image/webp",
                        type.empty() ? "no image that is known" : type,
                        ": only PNG, JPEG and WebP are decoded");
  Image image = type == "image/png"    ? read_png(bytes)
                : type == "image/jpeg" ? read_jpeg(bytes)
                                       : read_webp(bytes);
  while (std::max(image.width, image.height) > max_edge) image = halved(image);
  return image;
}

}  // namespace elastogen
