/* Compressed frames of DICOM files, by GDCM's codecs alone: headers are read elsewhere. Built where
 * CMake finds GDCM and a C++ compiler. No exception leaves. */
#include "volume/formats/dicom/codec.h"

#include <cstring>
#include <exception>
#include <memory>
#include <sstream>
#include <string>

#include <gdcmDataElement.h>
#include <gdcmFragment.h>
#include <gdcmImageCodec.h>
#include <gdcmJPEG2000Codec.h>
#include <gdcmJPEGCodec.h>
#include <gdcmJPEGLSCodec.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTrace.h>
#include <gdcmTransferSyntax.h>

namespace
{

/* What the header says of the frame. */
void describe(gdcm::ImageCodec &codec, const cvol_dicom_packed &packed)
{
    const unsigned int dimensions[3] = {packed.columns, packed.rows, 1};
    codec.SetNumberOfDimensions(2);
    codec.SetDimensions(dimensions);
    codec.SetPlanarConfiguration(0);
    codec.SetPhotometricInterpretation(packed.samples == 1
                                           ? gdcm::PhotometricInterpretation::MONOCHROME2
                                           : gdcm::PhotometricInterpretation::RGB);
    codec.SetPixelFormat(gdcm::PixelFormat(
        static_cast<unsigned short>(packed.samples), static_cast<unsigned short>(packed.allocated),
        static_cast<unsigned short>(packed.stored), static_cast<unsigned short>(packed.high),
        static_cast<unsigned short>(packed.is_signed)));
}

/* Of JPEG-LS, that function of GDCM which loses no memory where a stream is damaged (3.0.21): it
 * reads fragments, checks sizes, and is its heirs' alone. */
class lossless_codec : public gdcm::JPEGLSCodec
{
  public:
    bool decode_frame(std::istream &fragments, char *out, unsigned columns, unsigned rows)
    {
        return DecodeExtent(out, 0, columns - 1, 0, rows - 1, 0, 0, fragments);
    }
};

bool decode_jpeg_ls(const cvol_dicom_packed &packed, void *out)
{
    std::string fragments("\xfe\xff\x00\xe0\0\0\0\0\xfe\xff\x00\xe0", 12);
    for (int i = 0; i < 4; i++)
        fragments += static_cast<char>(packed.size >> (8 * i) & 0xff);
    fragments.append(reinterpret_cast<const char *>(packed.data), packed.size);
    fragments.append("\xfe\xff\xdd\xe0\0\0\0\0", 8);
    std::istringstream stream(fragments);
    lossless_codec codec;
    describe(codec, packed);
    return codec.decode_frame(stream, static_cast<char *>(out), packed.columns, packed.rows);
}

std::unique_ptr<gdcm::ImageCodec> make_codec(const gdcm::TransferSyntax &syntax)
{
    std::unique_ptr<gdcm::ImageCodec> codecs[2];
    codecs[0].reset(new gdcm::JPEGCodec);
    codecs[1].reset(new gdcm::JPEG2000Codec);
    for (auto &codec : codecs)
        if (codec->CanDecode(syntax))
            return std::move(codec);
    return nullptr;
}

bool decode(const cvol_dicom_packed &packed, void *out, size_t size)
{
    const gdcm::TransferSyntax syntax(gdcm::TransferSyntax::GetTSType(packed.transfer));
    if (packed.size > 0xfffffffe)
        return false;
    if (syntax == gdcm::TransferSyntax::JPEGLSLossless ||
        syntax == gdcm::TransferSyntax::JPEGLSNearLossless)
        return decode_jpeg_ls(packed, out);
    std::unique_ptr<gdcm::ImageCodec> codec = make_codec(syntax);
    if (!codec)
        return false;
    describe(*codec, packed);
    gdcm::SmartPointer<gdcm::SequenceOfFragments> sequence = new gdcm::SequenceOfFragments;
    gdcm::Fragment fragment;
    fragment.SetByteValue(reinterpret_cast<const char *>(packed.data),
                          gdcm::VL(static_cast<uint32_t>(packed.size)));
    sequence->AddFragment(fragment);
    gdcm::DataElement in(gdcm::Tag(0x7fe0, 0x0010)), decoded;
    in.SetVR(gdcm::VR::OB);
    in.SetValue(*sequence);
    if (!codec->Decode(in, decoded))
        return false;
    const gdcm::ByteValue *bytes = decoded.GetByteValue();
    if (!bytes || bytes->GetLength() < size)
        return false;
    std::memcpy(out, bytes->GetPointer(), size);
    return true;
}

} // namespace

extern "C" int cvol_dicom_codec_decode(const cvol_dicom_packed *packed, void *out, size_t size)
{
    try {
        gdcm::Trace::WarningOff();
        gdcm::Trace::ErrorOff();
        gdcm::Trace::DebugOff();
        return decode(*packed, out, size) ? 1 : 0;
    } catch (...) {
        return 0;
    }
}
