"""How the picture looks on its wall: behind what stands before it, and in the wall's light."""
