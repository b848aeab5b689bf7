/* Reads an image by the readers that ITK finds (ITK_AUTOLOAD_PATH), prints its geometry as JSON, writes its pixels
 * to RAW, and with a third name writes the image again.
 * usage: itk_copy IN RAW [OUT] [X0 X1 Y0 Y1 Z0 Z1] */
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <vector>

#include "itkImageIOFactory.h"

static itk::ImageIOBase::Pointer find(const char *name, itk::IOFileModeEnum mode)
{
    itk::ImageIOBase::Pointer io = itk::ImageIOFactory::CreateImageIO(name, mode);
    if (!io) {
        std::fprintf(stderr, "%s: ITK has no program for it\n", name);
        std::exit(1);
    }
    io->SetFileName(name);
    return io;
}

static void print(const itk::ImageIOBase &io)
{
    const unsigned n = io.GetNumberOfDimensions();
    std::printf("{\"type\": \"%s\", \"components\": %u, \"dimensions\": %u",
                itk::ImageIOBase::GetComponentTypeAsString(io.GetComponentType()).c_str(), io.GetNumberOfComponents(), n);
    for (unsigned a = 0; a < n; a++) {
        std::printf(", \"%u\": {\"size\": %zu, \"spacing\": %.9g, \"origin\": %.9g, \"direction\": [", a,
                    (size_t)io.GetDimensions(a), io.GetSpacing(a), io.GetOrigin(a));
        for (unsigned i = 0; i < n; i++)
            std::printf("%s%.9g", i ? ", " : "", io.GetDirection(a)[i]);
        std::printf("]}");
    }
    std::printf("}\n");
}

static void write(const itk::ImageIOBase &in, const char *name, const void *pixels)
{
    itk::ImageIOBase::Pointer out = find(name, itk::IOFileModeEnum::WriteMode);
    const unsigned n = in.GetNumberOfDimensions();
    out->SetNumberOfDimensions(n);
    for (unsigned a = 0; a < n; a++) {
        out->SetDimensions(a, in.GetDimensions(a));
        out->SetSpacing(a, in.GetSpacing(a));
        out->SetOrigin(a, in.GetOrigin(a));
        out->SetDirection(a, in.GetDirection(a));
    }
    out->SetComponentType(in.GetComponentType());
    out->SetNumberOfComponents(in.GetNumberOfComponents());
    out->SetIORegion(in.GetIORegion());
    out->Write(pixels);
}

int main(int argc, char **argv)
{
    if (argc != 3 && argc != 4 && argc != 9)
        return 2;
    try {
        itk::ImageIOBase::Pointer io = find(argv[1], itk::IOFileModeEnum::ReadMode);
        io->ReadImageInformation();
        const unsigned n = io->GetNumberOfDimensions();
        itk::ImageIORegion region(n);
        size_t bytes = io->GetComponentSize() * io->GetNumberOfComponents();
        for (unsigned a = 0; a < n; a++) {
            const bool is_box = argc == 9 && a < 3;
            const size_t begin = is_box ? std::strtoul(argv[3 + 2 * a], nullptr, 10) : 0;
            const size_t end = is_box ? std::strtoul(argv[4 + 2 * a], nullptr, 10) : io->GetDimensions(a);
            region.SetIndex(a, (long)begin);
            region.SetSize(a, end - begin);
            bytes *= end - begin;
        }
        io->SetIORegion(region);
        std::vector<char> pixels(bytes);
        io->Read(pixels.data());
        std::ofstream(argv[2], std::ios::binary).write(pixels.data(), (std::streamsize)bytes);
        print(*io);
        if (argc == 4)
            write(*io, argv[3], pixels.data());
    } catch (const itk::ExceptionObject &error) {
        std::fprintf(stderr, "%s\n", error.GetDescription());
        return 1;
    }
    return 0;
}
