"""How the picture looks on its wall: behind what stands in front of it, and in the wall's light."""
