/* Reading and writing .cvol files by ITK, and so by elastix, ANTs, 3D Slicer and SimpleITK.
 *
 * An image has the axes and the directions of the volume, in ITK's patient space (LPS). A file of
 * several times is an image of four dimensions; its channels are components of the pixels. Values
 * are those that the file states, such as Hounsfield units: samples with a scale or offset become
 * floats. Reading a region decodes only the bricks that it touches. Writing is lossless. */
#ifndef itkCvolImageIO_h
#define itkCvolImageIO_h

#include <string>

#include "cvol/cvol.h"
#include "itkImageIOBase.h"

namespace itk
{
class CvolImageIO : public ImageIOBase
{
  public:
    ITK_DISALLOW_COPY_AND_MOVE(CvolImageIO);
    using Self = CvolImageIO;
    using Superclass = ImageIOBase;
    using Pointer = SmartPointer<Self>;
    itkNewMacro(Self);
    itkTypeMacro(CvolImageIO, ImageIOBase);

    bool SupportsDimension(unsigned long dimension) override
    {
        return dimension >= 2 && dimension <= 4;
    }
    bool CanReadFile(const char *name) override;
    bool CanStreamRead() override
    {
        return true;
    }
    void ReadImageInformation() override;
    void Read(void *buffer) override;

    bool CanWriteFile(const char *name) override;
    void WriteImageInformation() override
    {
    }
    void Write(const void *buffer) override;

    ImageIORegion
    GenerateStreamableReadRegionFromRequestedRegion(const ImageIORegion &requested) const override
    {
        return requested;
    }

  protected:
    CvolImageIO();
    ~CvolImageIO() override;

  private:
    /* Throws ITK's exception with the message of the context. */
    void Check(int code) const;
    cvol_grid GridToWrite(const void *buffer) const;

    cvol_context *m_Context;
    cvol_grid m_Grid; /* of each volume of the file */
    int m_Times, m_Channels;
    bool m_Scales; /* values are not the samples */
};
} // namespace itk

#endif
