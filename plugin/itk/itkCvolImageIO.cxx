#include "itkCvolImageIO.h"

#include <cmath>
#include <cstring>
#include <vector>

#include "itkVersion.h"
extern "C" {
#include "volume/io/unit.h"
}

namespace itk
{
namespace
{
const char *const ending = ".cvol";

struct TypePair {
    cvol_type type;
    IOComponentEnum component;
};

const TypePair pairs[] = {
    {CVOL_UINT8, IOComponentEnum::UCHAR},   {CVOL_INT8, IOComponentEnum::CHAR},
    {CVOL_UINT16, IOComponentEnum::USHORT}, {CVOL_INT16, IOComponentEnum::SHORT},
    {CVOL_UINT32, IOComponentEnum::UINT},   {CVOL_INT32, IOComponentEnum::INT},
    {CVOL_FLOAT32, IOComponentEnum::FLOAT}, {CVOL_FLOAT64, IOComponentEnum::DOUBLE}};

IOComponentEnum ComponentOf(cvol_type type)
{
    for (const TypePair &pair : pairs)
        if (pair.type == type)
            return pair.component;
    return IOComponentEnum::UNKNOWNCOMPONENTTYPE;
}

/* False: .cvol files have no such type. `long` has the size of an int or twice that. */
bool TypeOf(cvol_type &type, IOComponentEnum component)
{
    if (component == IOComponentEnum::ULONG && sizeof(long) == 4)
        component = IOComponentEnum::UINT;
    if (component == IOComponentEnum::LONG && sizeof(long) == 4)
        component = IOComponentEnum::INT;
    for (const TypePair &pair : pairs)
        if (pair.component == component) {
            type = pair.type;
            return true;
        }
    return false;
}

/* The sign of axis `a` of the world between RAS and LPS. */
double SignOf(const cvol_grid &grid, unsigned a)
{
    return grid.space == CVOL_SPACE_RAS && a < 2 ? -1 : 1;
}

double SampleAt(const void *samples, cvol_type type, size_t i)
{
    switch (type) {
    case CVOL_UINT8:
        return static_cast<const uint8_t *>(samples)[i];
    case CVOL_INT8:
        return static_cast<const int8_t *>(samples)[i];
    case CVOL_UINT16:
        return static_cast<const uint16_t *>(samples)[i];
    case CVOL_INT16:
        return static_cast<const int16_t *>(samples)[i];
    case CVOL_UINT32:
        return static_cast<const uint32_t *>(samples)[i];
    case CVOL_INT32:
        return static_cast<const int32_t *>(samples)[i];
    case CVOL_FLOAT32:
        return static_cast<const float *>(samples)[i];
    default:
        return static_cast<const double *>(samples)[i];
    }
}

// Lengths of ITK are millimetres; those of an unknown unit are taken as they are.
double MillimetresOf(const char *unit)
{
    const double metres = cvol_unit_metres(unit);
    return metres > 0 ? metres * 1e3 : 1;
}
} // namespace

CvolImageIO::CvolImageIO()
    : m_Context(cvol_context_create()), m_Times(1), m_Channels(1), m_Scales(false)
{
    m_Grid = cvol_grid_make(1, 1, 1, CVOL_UINT8);
    SetNumberOfDimensions(3);
    AddSupportedReadExtension(ending);
    AddSupportedWriteExtension(ending);
}

CvolImageIO::~CvolImageIO()
{
    cvol_context_free(m_Context);
}

void CvolImageIO::Check(int code) const
{
    if (!m_Context)
        itkExceptionMacro("not enough memory");
    if (code)
        itkExceptionMacro(<< cvol_context_message(m_Context));
}

// ---- reading ----

bool CvolImageIO::CanReadFile(const char *name)
{
    cvol_file_kind kind = CVOL_FILE_OTHER;
    return m_Context && !cvol_file_read_kind(m_Context, &kind, name) &&
           (kind == CVOL_FILE_ARRAY || kind == CVOL_FILE_SERIES);
}

void CvolImageIO::ReadImageInformation()
{
    cvol_series *series = nullptr;
    Check(m_Context ? cvol_file_read_grid(m_Context, &m_Grid, GetFileName(), nullptr) : 1);
    Check(cvol_series_read(m_Context, &series, GetFileName()));
    m_Times = cvol_series_times(series);
    m_Channels = cvol_series_channels(series);
    const double step = m_Times > 1 ? cvol_series_time(series, 1) - cvol_series_time(series, 0) : 1;
    const double begin = cvol_series_time(series, 0);
    cvol_series_free(series);

    const unsigned dimensions = m_Times > 1 ? 4 : 3;
    const double millimetres = MillimetresOf(m_Grid.unit);
    SetNumberOfDimensions(dimensions);
    for (unsigned a = 0; a < 3; a++) {
        std::vector<double> direction(dimensions, 0.0);
        for (unsigned i = 0; i < 3; i++)
            direction[i] = SignOf(m_Grid, i) * m_Grid.direction[a][i];
        SetDimensions(a, m_Grid.dims[a]);
        SetSpacing(a, millimetres * m_Grid.spacing[a]);
        SetOrigin(a, SignOf(m_Grid, a) * millimetres * m_Grid.origin[a]);
        SetDirection(a, direction);
    }
    if (dimensions == 4) {
        SetDimensions(3, static_cast<SizeValueType>(m_Times));
        SetSpacing(3, step > 0 ? step : 1);
        SetOrigin(3, begin);
        SetDirection(3, std::vector<double>{0, 0, 0, 1});
    }
    m_Scales = m_Grid.value_scale != 1 || m_Grid.value_offset != 0;
    SetComponentType(m_Scales ? IOComponentEnum::FLOAT : ComponentOf(m_Grid.type));
    SetNumberOfComponents(static_cast<unsigned>(m_Channels));
    SetPixelType(m_Channels > 1 ? IOPixelEnum::VECTOR : IOPixelEnum::SCALAR);
}

void CvolImageIO::Read(void *buffer)
{
    const ImageIORegion &region = GetIORegion();
    size_t begin[3], end[3], samples = 1;
    size_t times[2] = {0, 1};
    for (unsigned a = 0; a < 3; a++) {
        const bool has = a < region.GetImageDimension();
        begin[a] = has ? static_cast<size_t>(region.GetIndex(a)) : 0;
        end[a] = begin[a] + (has ? region.GetSize(a) : 1);
        samples *= end[a] - begin[a];
    }
    if (region.GetImageDimension() > 3) {
        times[0] = static_cast<size_t>(region.GetIndex(3));
        times[1] = times[0] + region.GetSize(3);
    }
    const size_t channels = static_cast<size_t>(m_Channels), sample = cvol_type_size(m_Grid.type);
    const bool is_plain = channels == 1 && !m_Scales;
    std::vector<unsigned char> one(is_plain ? 0 : samples * sample);
    auto *to = static_cast<unsigned char *>(buffer);
    for (size_t time = times[0]; time < times[1];
         time++, to += samples * channels * GetComponentSize())
        for (size_t channel = 0; channel < channels; channel++) {
            cvol_file_part part = {};
            part.size = sizeof part;
            part.begin = begin;
            part.end = end;
            part.time = static_cast<int>(time);
            part.channel = static_cast<int>(channel);
            cvol_array *array = nullptr;
            int code = cvol_array_read_part(m_Context, &array, nullptr, GetFileName(), &part);
            void *into = is_plain ? static_cast<void *>(to) : one.data();
            if (!code)
                code = cvol_array_evaluate_box(m_Context, into, array, begin, end);
            cvol_array_free(array);
            Check(code);
            for (size_t i = 0; i < samples && m_Scales; i++)
                reinterpret_cast<float *>(to)[i * channels + channel] = static_cast<float>(
                    m_Grid.value_scale * SampleAt(one.data(), m_Grid.type, i) +
                    m_Grid.value_offset);
            for (size_t i = 0; i < samples && !m_Scales && !is_plain; i++)
                std::memcpy(to + (i * channels + channel) * sample, &one[i * sample], sample);
        }
}

// ---- writing ----

bool CvolImageIO::CanWriteFile(const char *name)
{
    return HasSupportedWriteExtension(name);
}

cvol_grid CvolImageIO::GridToWrite(const void *buffer) const
{
    cvol_type type = CVOL_UINT8;
    const unsigned dimensions = GetNumberOfDimensions();
    if (dimensions > 3 && GetDimensions(3) > 1)
        itkExceptionMacro(<< GetFileName()
                          << ": images of times cannot be written as .cvol: write each time");
    if (GetNumberOfComponents() != 1)
        itkExceptionMacro(<< GetFileName() << ": a pixel has " << GetNumberOfComponents()
                          << " components, and .cvol files are written with one");
    if (!buffer || !TypeOf(type, GetComponentType()))
        itkExceptionMacro(<< GetFileName() << ": pixels of type "
                          << GetComponentTypeAsString(GetComponentType())
                          << " cannot be written as .cvol");
    size_t dims[3] = {1, 1, 1};
    for (unsigned a = 0; a < 3 && a < dimensions; a++)
        dims[a] = GetDimensions(a);
    cvol_grid grid = cvol_grid_make(dims[0], dims[1], dims[2], type);
    grid.space = CVOL_SPACE_LPS;
    std::strcpy(grid.unit, "mm");
    for (unsigned a = 0; a < 3 && a < dimensions; a++) {
        grid.spacing[a] = GetSpacing(a);
        grid.origin[a] = GetOrigin(a);
        for (unsigned i = 0; i < 3 && i < dimensions; i++)
            grid.direction[a][i] = GetDirection(a)[i];
    }
    return grid;
}

void CvolImageIO::Write(const void *buffer)
{
    const cvol_grid grid = GridToWrite(buffer);
    cvol_compress_options options = cvol_compress_options_defaults();
    options.lossless = 1;
    cvol_array *array = nullptr;
    int code = m_Context ? cvol_compress(m_Context, &array, nullptr, buffer, &grid, &options) : 1;
    if (!code)
        code = cvol_array_write(m_Context, array, GetFileName(), nullptr);
    cvol_array_free(array);
    Check(code);
}
} // namespace itk
