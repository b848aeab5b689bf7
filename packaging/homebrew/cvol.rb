# brew install --HEAD ./packaging/homebrew/cvol.rb
class Cvol < Formula
  desc "Volumes that stay compressed while they are sliced, rendered and computed with"
  homepage "file:///cvol"
  license "BSD-3-Clause"
  head "file://#{File.expand_path("../..", __dir__)}", using: :git

  depends_on "cmake" => :build
  depends_on "pkgconf" => :build
  depends_on "giflib"
  depends_on "jansson"
  depends_on "libomp"
  depends_on "libpng"
  depends_on "libtiff"
  depends_on "webp"
  depends_on "zstd"
  uses_from_macos "zlib"

  def install
    system "cmake", "-S", ".", "-B", "build", "-DCVOL_TESTS=OFF", "-DCVOL_SETS=all", *std_cmake_args
    system "cmake", "--build", "build"
    system "cmake", "--install", "build"
  end

  test do
    assert_match "0.1.0", shell_output("#{bin}/cvol --version")
  end
end
