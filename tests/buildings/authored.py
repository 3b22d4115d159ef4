"""Small IFC models, authored for tests."""

import ifcopenshell
import ifcopenshell.guid
import numpy as np


class Author:
    """A model with one building; lengths are given in m and written in ``unit``, m."""

    def __init__(self, schema="IFC4", unit=1.0, turned=0.0, at=(0.0, 0.0, 0.0)):
        self.model = ifcopenshell.file(schema=schema)
        self.unit = unit or 1.0  # 0: no unit is written
        self.turned = turned
        self.history = None
        if schema == "IFC2X3":
            self.history = self._history()
        axis = self._axes((0.0, 0.0, 0.0))
        context = self.model.createIfcGeometricRepresentationContext(
            ContextIdentifier="Body", ContextType="Model", CoordinateSpaceDimension=3,
            Precision=1e-5, WorldCoordinateSystem=axis,
        )  # fmt: skip
        self.context = context
        units = []
        if unit:
            prefix = {1.0: None, 0.001: "MILLI"}.get(unit)
            length = self.model.createIfcSIUnit(None, "LENGTHUNIT", prefix, "METRE")
            if unit not in {1.0, 0.001}:  # feet
                dimensions = self.model.createIfcDimensionalExponents(1, 0, 0, 0, 0, 0, 0)
                measure = self.model.createIfcMeasureWithUnit(
                    self.model.create_entity("IfcLengthMeasure", unit), length
                )
                length = self.model.createIfcConversionBasedUnit(
                    dimensions, "LENGTHUNIT", "FOOT", measure
                )
            units.append(length)
        assigned = self.model.createIfcUnitAssignment(
            units or [self.model.createIfcSIUnit(None, "AREAUNIT", None, "SQUARE_METRE")]
        )
        self.project = self.root(
            "IfcProject", RepresentationContexts=[context], UnitsInContext=assigned
        )
        self.building = self.root(
            "IfcBuilding", ObjectPlacement=self.placement(at, turned), CompositionType="ELEMENT"
        )
        self._aggregate(self.project, [self.building])
        self.storeys = []

    def storey(self, name, height=0.0, elevation=None):
        storey = self.root(
            "IfcBuildingStorey", Name=name, CompositionType="ELEMENT",
            Elevation=(height if elevation is None else elevation) / self.unit,
            ObjectPlacement=self.placement((0.0, 0.0, height), 0.0, self.building.ObjectPlacement),
        )  # fmt: skip
        self._aggregate(self.building, [storey])
        self.storeys.append(storey)
        return storey

    def box(self, kind, low, high, *, storey=None, turned=0.0, **attributes):
        """Product whose body is a box from ``low`` to ``high`` in the storey's frame, m."""
        low, high = np.array(low, dtype=float), np.array(high, dtype=float)
        storey = storey or self.storeys[-1]
        place = self.placement(low, turned, storey.ObjectPlacement)
        product = self.root(
            kind, ObjectPlacement=place, Representation=self._box(high - low), **attributes
        )
        if kind == "IfcSpace":
            self._aggregate(storey, [product])
        elif kind != "IfcOpeningElement":
            self.root(
                "IfcRelContainedInSpatialStructure", RelatedElements=[product],
                RelatingStructure=storey,
            )  # fmt: skip
        return product

    def opening(self, wall, low, high, **options):
        opening = self.box("IfcOpeningElement", low, high, **options)
        self.root("IfcRelVoidsElement", RelatingBuildingElement=wall, RelatedOpeningElement=opening)
        return opening

    def door(self, wall, low, high, *, lining=0.0, along=0, **options):
        """A door in an opening from ``low`` to ``high``; ``along``: axis of the wall."""
        opening = self.opening(wall, low, high)
        width = high[along] - low[along]
        door = self.box(
            "IfcDoor", low, high, OverallWidth=width / self.unit,
            OverallHeight=(high[2] - low[2]) / self.unit, **options,
        )  # fmt: skip
        self.root("IfcRelFillsElement", RelatingOpeningElement=opening, RelatedBuildingElement=door)
        if lining:
            shape = self.root("IfcDoorLiningProperties", LiningThickness=lining / self.unit)
            self.root(
                "IfcRelDefinesByProperties", RelatedObjects=[door], RelatingPropertyDefinition=shape
            )
        return door

    def write(self, file):
        self.model.write(str(file))
        return file

    def root(self, kind, **attributes):
        return self.model.create_entity(
            kind, GlobalId=ifcopenshell.guid.new(), OwnerHistory=self.history, **attributes
        )

    def placement(self, at, turned=0.0, relative=None):
        return self.model.createIfcLocalPlacement(relative, self._axes(at, turned))

    def _axes(self, at, turned=0.0):
        point = self.model.createIfcCartesianPoint([float(v) / self.unit for v in at])
        x = self.model.createIfcDirection([float(np.cos(turned)), float(np.sin(turned)), 0.0])
        z = self.model.createIfcDirection([0.0, 0.0, 1.0])
        return self.model.createIfcAxis2Placement3D(point, z, x)

    def _box(self, size):
        dx, dy, dz = (float(v) / self.unit for v in size)
        corners = [(0.0, 0.0), (dx, 0.0), (dx, dy), (0.0, dy), (0.0, 0.0)]
        line = self.model.createIfcPolyline(
            [self.model.createIfcCartesianPoint(corner) for corner in corners]
        )
        profile = self.model.createIfcArbitraryClosedProfileDef("AREA", None, line)
        solid = self.model.createIfcExtrudedAreaSolid(
            profile, self._axes((0.0, 0.0, 0.0)), self.model.createIfcDirection([0.0, 0.0, 1.0]), dz
        )
        body = self.model.createIfcShapeRepresentation(self.context, "Body", "SweptSolid", [solid])
        return self.model.createIfcProductDefinitionShape(None, None, [body])

    def _aggregate(self, whole, parts):
        self.root("IfcRelAggregates", RelatingObject=whole, RelatedObjects=parts)

    def _history(self):
        person = self.model.createIfcPerson(FamilyName="Test")
        firm = self.model.createIfcOrganization(Name="Test")
        owner = self.model.createIfcPersonAndOrganization(person, firm)
        program = self.model.createIfcApplication(firm, "1", "Test", "test")
        return self.model.createIfcOwnerHistory(owner, program, None, "ADDED", None, None, None, 0)


def two_rooms(*, spaces=True, slab=True, door=0.9, lining=0.0, **options):
    """Two rooms of 4 × 3 m and 3 × 3 m beside each other, walls of 0.2 m, a door in between.

    The first one has a front door of 1 m in its south wall.
    """
    author = Author(**options)
    storey = author.storey("Ground Floor")
    wide = 7.6
    if slab:
        author.box("IfcSlab", (0, 0, -0.2), (wide, 3.4, 0.0))
    walls = {
        "south": ((0, 0, 0), (wide, 0.2, 2.5)),
        "north": ((0, 3.2, 0), (wide, 3.4, 2.5)),
        "west": ((0, 0.2, 0), (0.2, 3.2, 2.5)),
        "east": ((wide - 0.2, 0.2, 0), (wide, 3.2, 2.5)),
        "middle": ((4.2, 0.2, 0), (4.4, 3.2, 2.5)),
    }
    made = {name: author.box("IfcWall", *ends, Name=name) for name, ends in walls.items()}
    author.door(
        made["middle"], (4.2, 1.0, 0), (4.4, 1.0 + door, 2.1), lining=lining, along=1, Name="D1"
    )
    author.door(made["south"], (1.0, 0, 0), (2.0, 0.2, 2.1), Name="D0")
    if spaces:
        author.box("IfcSpace", (0.2, 0.2, 0), (4.2, 3.2, 2.5), Name="101", LongName="Office")
        author.box("IfcSpace", (4.4, 0.2, 0), (7.4, 3.2, 2.5), Name="102", LongName="Ward 3")
    return author, storey


def lift_tower(
    *, marked=("element",), doors=(True, True, True), walls=True, lifts=1, roof=False, rooms=()
):
    """Storeys of 8 × 6 m, 3 m apart; shafts of 2 × 2 m stand in a row at y = 0, from x = 4 on.

    Args:
        marked: "element" is a transport element on the lowest storey, "room" a space on each.
        doors: for each storey, if the lifts have a door, 1.0 m wide in the wall at y = 2.
        walls: False leaves out shaft walls and doors.
        lifts: number of shafts, 2 m apart.
        roof: adds a storey whose slab covers the shafts.
        rooms: for each storey, (number, name) of the space around the shafts, from y = 2.2 on.
    """
    author = Author()
    for k, has_door in enumerate(doors):
        storey = author.storey(f"Level {k + 1}", 3.0 * k)
        ends = 4.0 + 2.0 * lifts
        for low, high in (((0, 0), (4, 6)), ((4, 2), (8, 6)), ((ends, 0), (8, 2))):
            if high[0] > low[0]:
                author.box("IfcSlab", (*low, -0.2), (*high, 0.0))
        for low, high in (
            ((0, 0), (8, 0.2)), ((0, 5.8), (8, 6)), ((0, 0.2), (0.2, 5.8)), ((7.8, 0.2), (8, 5.8))
        ):  # fmt: skip
            author.box("IfcWall", (*low, 0), (*high, 2.5))
        for i in range(lifts):
            x, name = 4.0 + 2.0 * i, f"Lift {'AB'[i]}"
            if walls:
                author.box("IfcWall", (x, 0.2, 0), (x + 0.2, 2, 2.5))
                author.box("IfcWall", (x + 1.8, 0.2, 0), (x + 2, 2, 2.5))
                front = author.box("IfcWall", (x, 1.8, 0), (x + 2, 2, 2.5))
                if has_door:
                    author.door(front, (x + 0.5, 1.8, 0), (x + 1.5, 2, 2.1), Name=f"D{k}{i}")
            if "room" in marked:
                author.box("IfcSpace", (x + 0.2, 0.2, 0), (x + 1.8, 1.8, 2.5), Name=name)
            if "element" in marked and k == 0:
                author.box("IfcTransportElement", (x + 0.4, 0.4, 0), (x + 1.6, 1.6, 2.2), Name=name)
        if rooms:
            number, name = rooms[k]
            author.box(
                "IfcSpace", (0.2, 2.2, 0), (7.8, 5.8, 2.5), storey=storey, Name=number,
                LongName=name,
            )  # fmt: skip
    if roof:
        author.storey("Roof", 3.0 * len(doors))
        author.box("IfcSlab", (0, 0, -0.2), (8, 6, 0.0))
    return author


def ward_block(*, narrow=0.65):
    """Two storeys of 16 × 8 m, each with a corridor from (0.2, 4) to (15.8, 6), rooms south of it.

    ====== ============================== ============================================
    level  corridor                       rooms from the west, with their doors to it
    ====== ============================== ============================================
    1      South Corridor                 Foyer (x = 2 to 3), Store (7 to 7 + narrow)
    2      North Corridor                 Ward 3 (2 to 3), Radiology (7 to 8)
    ====== ============================== ============================================

    The Store also has a door of 1 m to the Foyer. A lift stands north of the corridors, its door
    from x = 12.5 to 13.5.
    """
    author = Author()
    levels = (
        ("Level 1", "South Corridor", ("Foyer", "Store"), narrow),
        ("Level 2", "North Corridor", ("Ward 3", "Radiology"), 1.0),
    )
    for k, (level, corridor, rooms, width) in enumerate(levels):
        author.storey(level, 3.0 * k)
        author.box("IfcSlab", (0, 0, -0.2), (16, 6.2, 0))
        for low, high in (
            ((0, 0), (16, 0.2)), ((0, 0.2), (0.2, 6)), ((15.8, 0.2), (16, 6)),
            ((12, 6.2), (12.2, 8.2)), ((13.8, 6.2), (14, 8.2)), ((12, 8), (14, 8.2)),
        ):  # fmt: skip
            author.box("IfcWall", (*low, 0), (*high, 2.5))
        north = author.box("IfcWall", (0, 6, 0), (16, 6.2, 2.5))
        south = author.box("IfcWall", (0.2, 3.8, 0), (15.8, 4, 2.5))
        middle = author.box("IfcWall", (5, 0.2, 0), (5.2, 3.8, 2.5))
        author.door(north, (12.5, 6, 0), (13.5, 6.2, 2.1), Name=f"L{k}")
        author.door(south, (2, 3.8, 0), (3, 4, 2.1), Name=f"A{k}")
        author.door(south, (7, 3.8, 0), (7 + width, 4, 2.1), Name=f"B{k}")
        if k == 0:
            author.door(middle, (5, 1.5, 0), (5.2, 2.5, 2.1), along=1, Name=f"C{k}")
        for name, number, low, high in (
            (corridor, "0", (0.2, 4), (15.8, 6)),
            (rooms[0], "1", (0.2, 0.2), (5, 3.8)),
            (rooms[1], "2", (5.2, 0.2), (15.8, 3.8)),
        ):
            author.box(
                "IfcSpace", (*low, 0), (*high, 2.5), Name=f"{'AB'[k]}{number}", LongName=name
            )
    author.box(
        "IfcTransportElement", (12.4, 6.5, 0), (13.6, 7.8, 2.2), storey=author.storeys[0],
        Name="Lift A",
    )  # fmt: skip
    return author
