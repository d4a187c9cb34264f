"""The class Node: names, lifetimes, order of opening and closing."""
