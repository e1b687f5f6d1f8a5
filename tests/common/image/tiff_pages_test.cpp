// Which page of a TIFF file is the photograph. The files are libtiff's own, written here.
#include <tiffio.h>

#include <cstdint>
#include <string>
#include <vector>

#include "common/image/image_files.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

struct Page {
  std::uint32_t width = 0, height = 0, kind = 0;
  std::uint16_t meaning = PHOTOMETRIC_MINISBLACK;
  int below = 0;  ///< so many of the pages that follow are its SubIFDs
  bool dng = false;
};

void write_page(TIFF* tiff, const Page& page) {
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, page.width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, page.height);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, page.meaning == PHOTOMETRIC_RGB ? 3 : 1);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, page.meaning);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  if (page.kind != 0) TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, page.kind);
  if (page.dng) TIFFSetField(tiff, TIFFTAG_DNGVERSION, "\1\4\0\0");
  const std::vector<std::uint64_t> places(static_cast<std::size_t>(page.below));
  if (page.below > 0) TIFFSetField(tiff, TIFFTAG_SUBIFD, page.below, places.data());
  std::vector<std::uint8_t> row(std::size_t{3} * page.width, 100);
  for (std::uint32_t y = 0; y < page.height; ++y) CHECK_EQUAL(1, TIFFWriteScanline(tiff, row.data(), y, 0));
  CHECK_EQUAL(1, TIFFWriteDirectory(tiff));
}

const Page kPhotograph{400, 300};
const Page kThumbnail{40, 30, FILETYPE_REDUCEDIMAGE, PHOTOMETRIC_RGB};
const Page kMosaic{400, 300, 0, PHOTOMETRIC_CFA};

}  // namespace

TEST_GROUP(TiffPages) {
  strobe::testing::TemporaryFolder folder;

  strobe::Result<strobe::image::Raster> decoded(const std::vector<Page>& pages) {
    const std::string path = (folder / "pages.nef").string();
    TIFF* const tiff = TIFFOpen(path.c_str(), "w");
    CHECK(tiff != nullptr);
    for (const Page& page : pages) write_page(tiff, page);
    TIFFClose(tiff);
    const std::string bytes = strobe::testing::read_text(path);
    return strobe::image::decode({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()});
  }

  void check_refused(const std::string& why, const std::vector<Page>& pages) {
    STRCMP_CONTAINS(why.c_str(), strobe::testing::error_of(decoded(pages)).c_str());
  }

  void check_width(int width, const std::vector<Page>& pages) {
    const auto read = decoded(pages);
    CHECK_TEXT(read.has_value(), strobe::testing::error_of(read).c_str());
    CHECK_EQUAL(width, read->width());
  }
};

// As Nikon and Sony write them: the sensor's numbers below a thumbnail; a preview of full size may be beside them.
TEST(TiffPages, OfACamerasRawFileAreRefused) {
  const std::string why = "it is a camera's RAW file, of which strobe-raw makes a mosaic TIFF";
  Page first = kThumbnail;
  first.below = 2;
  check_refused(why, {first, {400, 300, FILETYPE_REDUCEDIMAGE, PHOTOMETRIC_RGB}, kMosaic});
  check_refused(why, {kThumbnail, kMosaic});
  check_refused(why, {kMosaic});
  Page converted = kPhotograph;
  converted.dng = true;
  check_refused(why, {converted});
}

TEST(TiffPages, AfterAThumbnailAreNotReadAsIt) {
  check_refused("the first page of the TIFF, 40 x 30 pixels, is a thumbnail of another of 400 x 300",
                {kThumbnail, kPhotograph});
  check_refused("is a thumbnail of another of 400 x 300", {{40, 30}, kPhotograph});
  Page first = kThumbnail;
  first.below = 1;
  check_refused("is a thumbnail of another of 400 x 300", {first, kPhotograph});
}

// Programs keep a thumbnail, masks and smaller copies behind the picture.
TEST(TiffPages, BehindThePhotographAreLeftOut) {
  check_width(400, {kPhotograph});
  check_width(400, {kPhotograph, kThumbnail, {400, 300, FILETYPE_MASK}});
  Page first = kPhotograph;
  first.below = 2;
  check_width(400, {first, {200, 150, FILETYPE_REDUCEDIMAGE}, kThumbnail});
  check_width(40, {kThumbnail});
}
