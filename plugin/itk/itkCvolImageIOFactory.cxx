/* The factory of CvolImageIO, which ITK finds in the folders of the variable ITK_AUTOLOAD_PATH. */
#include "itkCreateObjectFunction.h"
#include "itkCvolImageIO.h"
#include "itkObjectFactoryBase.h"
#include "itkVersion.h"

namespace itk
{
class CvolImageIOFactory : public ObjectFactoryBase
{
  public:
    using Self = CvolImageIOFactory;
    using Superclass = ObjectFactoryBase;
    using Pointer = SmartPointer<Self>;
    itkFactorylessNewMacro(Self);
    itkTypeMacro(CvolImageIOFactory, ObjectFactoryBase);

    const char *GetITKSourceVersion() const override
    {
        return ITK_SOURCE_VERSION;
    }
    const char *GetDescription() const override
    {
        return "reads and writes .cvol files";
    }

  protected:
    CvolImageIOFactory()
    {
        RegisterOverride("itkImageIOBase", "itkCvolImageIO", "cvol", true,
                         CreateObjectFunction<CvolImageIO>::New());
    }
};
} // namespace itk

extern "C" __attribute__((visibility("default"))) itk::ObjectFactoryBase *itkLoad()
{
    static itk::CvolImageIOFactory::Pointer factory = itk::CvolImageIOFactory::New();
    return factory.GetPointer();
}
