/* Writes the files of this folder with libopenvdb (10.0): grids of all types that cvol reads, with
 * the values that test_vdb.c computes.
 *
 *     c++ -std=c++17 -O1 make_vdb.cpp -o make_vdb -lopenvdb -ltbb -lImath && ./make_vdb */
#include <cmath>
#include <string>

#include <openvdb/io/File.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

namespace
{
using openvdb::Coord;
using openvdb::math::Transform;

template <typename Grid> void fill(Grid &grid)
{
    using Value = typename Grid::ValueType;
    auto place = grid.getAccessor();
    for (int x = -5; x < 12; x++)
        for (int y = 0; y < 9; y++)
            for (int z = 3; z < 17; z++) {
                const int value = x + 10 * y + 100 * z, rest = (x + 2 * y + 3 * z) & 7;
                if (rest < 3)
                    place.setValueOn(Coord(x, y, z), static_cast<Value>(value % 2 ? value : 0));
                else if (rest == 3 && x < 8)
                    place.setValueOff(Coord(x, y, z), static_cast<Value>(7));
                else if (rest == 4 && y < 8)
                    place.setValueOff(Coord(x, y, z), static_cast<Value>(-1));
            }
}

void fill(openvdb::MaskGrid &grid)
{
    for (int x = -5; x < 12; x++)
        for (int y = 0; y < 9; y++)
            for (int z = 3; z < 17; z++)
                if (((x + 2 * y + 3 * z) & 7) < 3)
                    grid.tree().setValueOn(Coord(x, y, z));
}

template <typename Grid>
void add(openvdb::GridPtrVec &grids, const std::string &name, int background,
         Transform::Ptr transform, bool half = false)
{
    typename Grid::Ptr grid = Grid::create(static_cast<typename Grid::ValueType>(background));
    fill(*grid);
    grid->setName(name);
    grid->setTransform(transform);
    grid->setSaveFloatAsHalf(half);
    grids.push_back(grid);
}

/* A transform of each kind that the file format has. */
Transform::Ptr affine()
{
    const double rows[16] = {0, 2, 0, 0, -3, 0, 0, 0, 0, 0.5, 4, 0, 10, 20, 30, 1};
    return Transform::createLinearTransform(openvdb::Mat4d(rows));
}

template <typename Map> Transform::Ptr of(const Map &map)
{
    return Transform::Ptr(new Transform(openvdb::math::MapBase::Ptr(new Map(map))));
}

openvdb::GridPtrVec kinds()
{
    using namespace openvdb::math;
    using openvdb::Vec3d;
    using HalfGrid = openvdb::Grid<openvdb::tree::Tree4<half, 5, 4, 3>::Type>;
    HalfGrid::registerGrid();
    openvdb::GridPtrVec grids;
    add<openvdb::FloatGrid>(grids, "float", -4, of(UniformScaleMap(0.25)));
    add<openvdb::DoubleGrid>(grids, "double", 5, affine());
    add<openvdb::FloatGrid>(grids, "float_as_half", 1, of(ScaleMap(Vec3d(1, 2, 3))), true);
    add<openvdb::DoubleGrid>(grids, "double_as_half", 0, of(TranslationMap(Vec3d(1, 2, 3))), true);
    add<HalfGrid>(grids, "half", 1, of(ScaleTranslateMap(Vec3d(1, 2, 3), Vec3d(-1, 0, 1))));
    add<openvdb::Int32Grid>(grids, "int32", 1,
                            of(UniformScaleTranslateMap(2, Vec3d(0.5, 0, -0.5))));
    add<openvdb::Int64Grid>(grids, "int64", 3, of(UnitaryMap(Vec3d(0, 0, 1), M_PI / 2)));
    add<openvdb::BoolGrid>(grids, "bool", 1, Transform::createLinearTransform(1));
    add<openvdb::MaskGrid>(grids, "mask", 0, Transform::createLinearTransform(1));
    return grids;
}
} // namespace

int main()
{
    openvdb::initialize();
    const openvdb::GridPtrVec grids = kinds();
    const struct {
        const char *name;
        uint32_t compression;
    } files[] = {
        {"plain.vdb", 0},
        {"zip.vdb", openvdb::io::COMPRESS_ZIP},
        {"zip_mask.vdb", openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK},
        {"blosc_mask.vdb", openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK}};
    for (const auto &each : files) {
        openvdb::io::File file(each.name);
        file.setCompression(each.compression);
        file.write(grids);
    }
    openvdb::FloatGrid::Ptr frustum = openvdb::FloatGrid::create();
    fill(*frustum);
    frustum->setName("frustum");
    frustum->setTransform(Transform::createFrustumTransform(
        openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(100)), 0.5, 10));
    openvdb::io::File("frustum.vdb").write(openvdb::GridPtrVec{frustum});
}
